"""A light to look at materials under, made of formulas: a dim room, a sky, two lamps and a warm wall."""

import numpy as np

# Latitude and longitude of an image that is smooth but for the edges of its lamps.
HEIGHT, WIDTH = 256, 512


def _direction() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y (up) and z of every texel's centre, in Mitsuba's convention of latitude and longitude."""
    v, u = (np.arange(HEIGHT) + 0.5) / HEIGHT, (np.arange(WIDTH) + 0.5) / WIDTH
    theta, phi = np.pi * v[:, None], 2.0 * np.pi * u[None, :]
    return np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi, -np.sin(theta) * np.cos(phi)


def _panel(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, at: tuple[float, float, float], cosine: float
) -> np.ndarray:
    """1 within a cone around a direction, with a soft edge of a few texels."""
    axis = np.asarray(at) / np.linalg.norm(at)
    inside = x * axis[0] + y * axis[1] + z * axis[2]
    return np.clip((inside - cosine) / 0.02 + 0.5, 0.0, 1.0)


def studio() -> np.ndarray:
    """Radiance of the light, float32, HEIGHT x WIDTH x 3."""
    x, y, z = _direction()
    up = 0.5 + 0.5 * y
    sky, floor = np.array([0.74, 0.80, 0.90]), np.array([0.16, 0.15, 0.14])
    # A soft step at the horizon, so that glass shows where it bends light.
    edge = 1.0 / (1.0 + np.exp(-18.0 * y))
    light = edge[..., None] * sky * (0.35 + 0.65 * up[..., None]) + (1.0 - edge[..., None]) * floor
    light = light + _panel(x, y, z, (-0.8, 0.9, 0.7), 0.93)[..., None] * np.array([9.0, 8.6, 8.0])
    light = light + _panel(x, y, z, (1.0, 0.25, 0.3), 0.97)[..., None] * np.array([4.0, 4.4, 5.0])
    warm = np.clip(-z, 0.0, 1.0) ** 2 * np.clip(1.0 - np.abs(y) / 0.6, 0.0, 1.0)
    # Stripes behind the sphere: what is seen through glass should have a shape.
    stripes = 0.5 + 0.5 * np.tanh(6.0 * np.sin(10.0 * np.arctan2(x, -z)))
    light = light + (warm * (0.25 + 0.75 * stripes))[..., None] * np.array([1.1, 0.65, 0.30])
    return light.astype(np.float32)
