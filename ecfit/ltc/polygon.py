"""How much of a lobe a polygon covers: in closed form for the clamped cosine and its linear maps."""

import math
from typing import Any

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError

Array = jax.Array


def polygon_share(vertices: Any) -> Array:
    """The part of the clamped cosine's light that comes through a polygon: its form factor, in [0, 1].

    The sum over edges of Baum et al. 1989, eq. 1 (Lambert's formula), after clipping at the horizon z = 0.

    Args:
        vertices: shape (n, 3), n >= 3: corners in order, either way round, of a planar polygon that does not
            cross itself, in the local frame (the shaded point at 0, z along the normal). No edge may run
            through 0.

    Returns a scalar; works under jit, vmap and grad. Raises `EcfitError` for other shapes.
    """
    vertices = jnp.asarray(vertices, dtype=jnp.float64)
    if vertices.ndim != 2 or vertices.shape[0] < 3 or vertices.shape[1] != 3:
        raise EcfitError(f"vertices must have shape (n, 3) with n >= 3, got {vertices.shape}")
    points, any_above = _clipped(vertices)
    following = jnp.roll(points, -1, axis=0)
    # Points that no part of the polygon above the horizon has are put up: they weigh nothing.
    up = jnp.array([0.0, 0.0, 1.0])
    total = jnp.sum(_edge(jnp.where(any_above, points, up), jnp.where(any_above, following, up)))
    return jnp.abs(total) / (2.0 * math.pi)


def lobe_share(vertices: Any, scale: Any) -> Array:
    """The same for the lobe `stretched_cosine`: the integral of D over the directions of the polygon.

    Its corners are taken through M^-1 = diag(1 / a, 1 / a, 1). The multiple scattering of a light of
    radiance L is F_ms (1 - E_o) L times this, as the lobe's amplitude pi (1 - E_avg) cancels against its
    normalisation (MSBRDF blog, Mayaux 2018 part 2, which leaves a(alpha) open).

    Args:
        vertices: see `polygon_share`.
        scale: a > 0, the quantity "ltc-scale".
    """
    vertices = jnp.asarray(vertices, dtype=jnp.float64)
    inverse = 1.0 / jnp.asarray(scale, dtype=jnp.float64)
    return polygon_share(vertices * jnp.stack([inverse, inverse, jnp.ones_like(inverse)]))


def _clipped(start: Array) -> tuple[Array, Array]:
    """Corners of the part with z >= 0, shape (2 n, 3), some of them repeated; and whether there is one.

    Each edge has the two ends of its part above the horizon, and an edge below it repeats the end before:
    so the way from where the polygon sets to where it rises is one arc of the horizon.
    """
    end = jnp.roll(start, -1, axis=0)
    low, high = start[:, 2], end[:, 2]
    step = jnp.where(low == high, 1.0, low - high)
    crossing = (start + (end - start) * (low / step)[:, None]).at[:, 2].set(0.0)
    first = jnp.where((low < 0.0)[:, None], crossing, start)
    last = jnp.where((high < 0.0)[:, None], crossing, end)
    above = (low > 0.0) | (high > 0.0)
    points = jnp.stack([first, last], axis=1).reshape(-1, 3)
    index = jnp.where(jnp.repeat(above, 2), jnp.arange(points.shape[0]), -1)
    latest = jax.lax.cummax(index)
    # Before the first edge above: the last one, as the polygon is closed.
    latest = jnp.where(latest < 0, latest[-1], latest)
    return points[jnp.maximum(latest, 0)], jnp.any(above)


def _edge(a: Array, b: Array) -> Array:
    """Angle of each edge times the z of its plane's unit normal."""
    cross, dot = jnp.cross(a, b), jnp.sum(a * b, axis=-1)
    square = jnp.sum(cross * cross, axis=-1)
    # 1e-30 of the lengths: an edge seen end on has no angle, and its slope would be 0 / 0.
    seen = square > 1e-30 * jnp.sum(a * a, axis=-1) * jnp.sum(b * b, axis=-1)
    sine = jnp.sqrt(jnp.where(seen, square, 1.0))
    return jnp.where(seen, jnp.arctan2(sine, dot) / sine * cross[:, 2], 0.0)
