"""Mean, variance and maximum of the weight f mu_i / p: by integration, and by drawing.

The panels of the integrals end where f bends (theta_i = theta_o, right angles of azimuth) and where a
transformed cosine's terminator runs, beyond which its density is 0. A density that goes to 0 there where f
does not makes the second moment diverge as a logarithm: the variance is infinite, and the energy `beyond` is
never drawn.
"""

from typing import NamedTuple

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.quadrature.rules import gauss_legendre
from ecfit.sampling.techniques import Technique

Array = jax.Array

# Gauss nodes a panel.
_NODES = 20
_HORIZON = 1e-9


class Weights(NamedTuple):
    """Statistics of f mu_i / p, arrays of one shape.

    Attributes:
        mean: the expected weight; less than the albedo where the technique leaves directions out.
        variance: second moment less the square of the mean; of `drawn` the sample's.
        largest: of the weights found.
        beyond: energy in directions that are never drawn (0 of `drawn`).
    """

    mean: Array
    variance: Array
    largest: Array
    beyond: Array


def _panels(ends: Array, nodes: int) -> tuple[Array, Array]:
    """Nodes and weights between sorted ends, with squares at both sides of a panel, which resolve roots."""
    x, w = gauss_legendre(nodes)
    ends = jnp.sort(ends)
    low, high = ends[:-1, None], ends[1:, None]
    half = 0.5 * (high - low)
    weight = half * 2.0 * x * w
    points = jnp.concatenate([low + half * x * x, high - half * x * x])
    return points.ravel(), jnp.concatenate([weight, weight]).ravel()


def _direction(theta: Array, phi: Array) -> Array:
    s = jnp.sin(theta)
    return jnp.stack([s * jnp.cos(phi), s * jnp.sin(phi), jnp.cos(theta)])


def _view(mu: Array) -> tuple[Array, Array]:
    mu = jnp.maximum(mu, _HORIZON)
    theta = jnp.arccos(jnp.minimum(mu, 1.0))
    return theta, _direction(theta, jnp.zeros_like(theta))


def moments(
    model: BSDF, technique: Technique, mu: Array, r: Array, cut: Array | float = 1e-12, nodes: int = _NODES
) -> tuple[Array, Array, Array, Array]:
    """Mean, second moment, energy beyond and largest weight at scalars mu and r; differentiable.

    The second moment and the maximum leave out densities of `cut` and less: it is finite where it diverges.
    """
    theta_o, wo = _view(mu)
    p, q = technique.terminator(mu, r)
    flat = jnp.abs(q) < 1e-9
    q = jnp.where(flat, 1.0, q)
    zero, half = 0.0 * theta_o, 0.5 * jnp.pi
    start = jnp.where(flat, half, jnp.clip(jnp.arctan2(p, jnp.abs(q)), 0.0, half))

    def ring(theta: Array) -> tuple[Array, Array]:
        s, c = jnp.sin(theta), jnp.cos(theta)
        cosine = jnp.where(flat, -1.0, p * c / jnp.where(s > 0.0, q * s, 1.0))
        inside = jnp.abs(cosine) < 1.0
        stop = jnp.where(inside, jnp.arccos(jnp.where(inside, cosine, 0.0)), jnp.pi)
        phi, weight = _panels(jnp.stack([zero, zero + half, stop, zero + jnp.pi]), nodes)

        def one(angle: Array) -> tuple[Array, Array]:
            wi = _direction(theta, angle)
            value, density = model.f(wo, wi) * wi[2], technique.pdf(wi, mu, r)
            seen = density > cut
            found = jnp.where(seen, value / jnp.where(seen, density, 1.0), 0.0)
            reached = jnp.where(density > 0.0, 1.0, 0.0)
            parts = jnp.stack([reached, found, 1.0 - reached])
            return value * parts, found

        values, found = jax.vmap(one)(phi)
        return 2.0 * s * (weight @ values), jnp.max(found)

    theta, weight = _panels(jnp.stack([zero, theta_o, start, zero + half]), nodes)
    values, largest = jax.vmap(ring)(theta)
    mean, second, beyond = weight @ values
    return mean, second, beyond, jnp.max(largest)


@eqx.filter_jit
def _integrated(model: BSDF, technique: Technique, name: str, cut: Array, mu: Array, r: Array) -> Weights:
    def one(point: tuple[Array, Array]) -> Weights:
        made = model.with_parameters({name: point[1]})
        mean, second, beyond, largest = moments(made, technique, *point, cut=cut)
        return Weights(mean, second - mean * mean, largest, beyond)

    return jax.lax.map(one, (mu.ravel(), r.ravel()), batch_size=16)


def integrated(
    model: BSDF,
    technique: Technique,
    mu: object,
    r: object,
    cut: float = 1e-12,
    name: str = "diffuse_roughness",
) -> Weights:
    """The statistics by integration at points, arrays that broadcast.

    Args:
        model: a reflecting, isotropic BSDF that bends at most where this module's panels end.
        technique: how wi is drawn.
        mu, r: cosine of the view, and the roughness, which is also the model's parameter `name`.
        cut: densities per steradian up to which weights are left out of variance and maximum, which are
            infinite otherwise where a density goes to 0 and f does not.
    """
    mu, r = jnp.broadcast_arrays(jnp.asarray(mu, float), jnp.asarray(r, float))
    found = _integrated(model, technique, name, jnp.asarray(cut, float), mu, r)
    return Weights(*(v.reshape(mu.shape) for v in found))


@eqx.filter_jit
def _weights(model: BSDF, technique: Technique, u: Array, mu: Array, r: Array) -> Array:
    _, wo = _view(mu)

    def one(numbers: Array) -> Array:
        wi = technique.sample(numbers, mu, r)
        density = technique.pdf(wi, mu, r)
        value = jnp.where(wi[2] > 0.0, model.f(wo, wi) * wi[2], 0.0)
        return jnp.where(density > 0.0, value / jnp.where(density > 0.0, density, 1.0), 0.0)

    return jax.vmap(one)(u)


def drawn(
    model: BSDF,
    technique: Technique,
    mu: float,
    r: float,
    count: int = 100_000,
    seed: int = 0,
    name: str = "diffuse_roughness",
) -> Weights:
    """The statistics of `count` drawn weights at one point."""
    u = np.random.default_rng(seed).random((count, technique.needs))
    made = model.with_parameters({name: jnp.asarray(r)})
    found = _weights(made, technique, jnp.asarray(u), jnp.asarray(mu, float), jnp.asarray(r, float))
    return Weights(jnp.mean(found), jnp.var(found), jnp.max(found), jnp.asarray(0.0))
