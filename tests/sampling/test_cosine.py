"""Transformed cosines: densities integrate to 1, samplers draw from their densities."""

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.sampling import TransformedCosine

MATRICES = {
    "cosine": (1.0, 0.0, 1.0, 0.0),
    "towards": (0.8, 0.7, 1.2, -0.5),
    "away": (0.9, -0.3, 1.1, 0.4),
}


def lobe(name: str, clipped: bool) -> TransformedCosine:
    a, b, c, d = (jnp.asarray(v) for v in MATRICES[name])
    return TransformedCosine(a, b, c, d, clipped)


def sphere(count: int = 200):
    """Midpoints of equal areas on the sphere, and the area of each."""
    z = (np.arange(count) + 0.5) / count * 2.0 - 1.0
    phi = (np.arange(2 * count) + 0.5) / (2 * count) * 2.0 * np.pi
    z, phi = (v.ravel() for v in np.meshgrid(z, phi, indexing="ij"))
    s = np.sqrt(1.0 - z * z)
    return jnp.asarray(np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)), 4.0 * np.pi / z.size


def draw(made: TransformedCosine, count: int) -> np.ndarray:
    u = jnp.asarray(np.random.default_rng(1).random((count, 2)))
    return np.asarray(jax.vmap(made.sample)(u))


@pytest.mark.parametrize("clipped", [False, True])
@pytest.mark.parametrize("name", MATRICES)
def test_the_density_integrates_to_one(name: str, clipped: bool):
    points, area = sphere()
    density = jax.vmap(lobe(name, clipped).pdf)(points)
    assert float(jnp.sum(density) * area) == pytest.approx(1.0, abs=3e-4)


@pytest.mark.parametrize("clipped", [False, True])
@pytest.mark.parametrize("name", MATRICES)
def test_moments_of_samples_are_those_of_the_density(name: str, clipped: bool):
    made = lobe(name, clipped)
    points, area = sphere()
    weight = np.asarray(jax.vmap(made.pdf)(points)) * area
    drawn = draw(made, 40_000)
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(drawn.mean(axis=0), weight @ np.asarray(points), atol=0.012)
    np.testing.assert_allclose((drawn**2).mean(axis=0), weight @ np.asarray(points) ** 2, atol=0.01)


@pytest.mark.parametrize("name", ["towards", "away"])
def test_clipping_keeps_samples_above_the_horizon(name: str):
    assert draw(lobe(name, True), 5000)[:, 2].min() >= -1e-12
    below = (draw(lobe(name, False), 20_000)[:, 2] < 0.0).mean()
    assert below == pytest.approx(1.0 - float(lobe(name, True).share), abs=0.01)


def test_the_plain_cosine_is_mu_over_pi():
    points, _ = sphere(10)
    np.testing.assert_allclose(
        jax.vmap(lobe("cosine", True).pdf)(points), np.maximum(points[:, 2], 0.0) / np.pi, atol=1e-15
    )
