"""The general rule: any f(wo, wi), over the hemispheres of wi."""

from collections.abc import Callable
from typing import ClassVar

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import Estimate, graded, integrate

Array = jax.Array

# Stands for mu = 0: far below any width of E, far above what would underflow in a model.
_HORIZON = 1e-12


class Hemisphere(Measure):
    """Gauss-Legendre panels in (theta_i, phi), graded towards the mirror direction.

    Panels halve towards theta_i = theta_o and phi = pi (for transmission: the straight-through
    direction), so that a lobe around it is resolved down to a width of about pi 2^-depth. A BSDF that
    peaks elsewhere or has discontinuities it does not tell of converges slowly, and its entries say so.

    Attributes:
        f: the BSDF value f(wo, wi) of unit vectors of shape (3,), without the cosine.
        transmissive: whether f is to be integrated over the lower hemisphere at all.
        edges: cosines wi.z of the discontinuities of f(wo, .) for a given mu (see `BSDF.edges`).
        azimuths: angles in (0, pi) between wo and wi about the normal at which f jumps or bends.
    """

    f: Callable[[Array, Array], Array]
    transmissive: bool = True
    edges: Callable[[Array], Array] | None = None
    azimuths: tuple[float, ...] = eqx.field(static=True, default=())

    default_level: ClassVar[int] = 3
    # (dyadic depth, nodes per panel and dimension) of each level.
    ORDERS: ClassVar[tuple[tuple[int, int], ...]] = (
        (0, 8),
        (0, 12),
        (1, 12),
        (2, 14),
        (4, 14),
        (6, 18),
        (9, 20),
    )

    @property
    def levels(self) -> tuple[int, ...]:
        sides = (2 if self.transmissive else 1) * (1 + len(self.azimuths))
        return tuple(4 * sides * ((depth + 1) * count) ** 2 for depth, count in self.ORDERS)

    @staticmethod
    def _hidden(f: Callable[[Array], Array], theta_o: Array, largest: Array, depth: int) -> Array:
        """Energy of a peak at the mirror direction that falls between the nodes, from a few values of f.

        Compares f at angles pi 2^-k off that direction, deep in the innermost panels, with its largest value
        on the nodes; an excess stands for its annulus.
        """
        delta = jnp.pi * 0.5 ** np.arange(depth + 4, 40)
        sides = theta_o + jnp.stack([delta, -delta])
        inside = (sides >= 0.0) & (sides <= 0.5 * jnp.pi)
        found = jnp.abs(jax.vmap(jax.vmap(f))(jnp.where(inside, sides, theta_o)))
        excess = jnp.maximum(jnp.where(inside, found, 0.0) - largest, 0.0)
        return jnp.sum(jnp.max(excess, axis=0) * jnp.pi * delta * delta) * jnp.cos(theta_o)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        depth, count = self.ORDERS[level]
        rule = graded(depth, count)
        x, width = jnp.asarray(rule.nodes), jnp.asarray(rule.widths)
        # Models are defined for wo.z > 0: the horizon is the limit.
        mu = jnp.maximum(mu, _HORIZON)
        theta_o = jnp.arccos(jnp.clip(mu, 0.0, 1.0))
        wo = jnp.stack([jnp.sin(theta_o), jnp.zeros_like(mu), mu])
        edges = jnp.zeros(0) if self.edges is None else self.edges(mu)

        def polar(sign: float) -> tuple[Array, Array]:
            """Nodes and weights in theta_i: pieces between the edges, graded towards theta_o."""
            jumps = jnp.arccos(jnp.clip(sign * edges, 0.0, 1.0))
            ends = jnp.sort(jnp.concatenate([jnp.stack([0.0 * theta_o, theta_o, half]), jumps]))
            low, high = ends[:-1, None], ends[1:, None]
            theta = jnp.where(high <= theta_o, high - (high - low) * x, low + (high - low) * x).ravel()
            return theta, ((high - low) * width).ravel() * jnp.sin(theta) * jnp.cos(theta)

        half = jnp.asarray(0.5 * jnp.pi)
        # phi in [0, pi] and its mirror image, in pieces between the azimuths that are graded towards pi.
        ends = np.array([0.0, *sorted(self.azimuths), np.pi])
        piece = np.diff(ends)[:, None]
        phi = jnp.ravel(ends[1:, None] - piece * x)
        phi = jnp.concatenate([phi, 2.0 * jnp.pi - phi])
        w_phi = jnp.tile(jnp.ravel(piece * width), 2)

        def side(sign: float) -> Estimate:
            theta, w_theta = polar(sign)

            def value(t: Array, p: Array) -> Array:
                sin = jnp.sin(t)
                wi = jnp.stack([sin * jnp.cos(p), sin * jnp.sin(p), sign * jnp.cos(t)])
                return self.f(wo, wi)

            values = jax.vmap(jax.vmap(value, (None, 0)), (0, None))(theta, phi)
            found = integrate(values * w_theta[:, None] * w_phi, rule, rule)
            # Nodes of an empty panel (theta_o = 0) have seen nothing.
            largest = jnp.max(jnp.where(w_theta[:, None] > 0.0, jnp.abs(values), 0.0))
            hidden = self._hidden(lambda t: value(t, jnp.asarray(jnp.pi)), theta_o, largest, depth)
            return Estimate(found.value, found.error + jax.lax.stop_gradient(hidden))

        none = Estimate(jnp.zeros_like(mu), jnp.zeros_like(mu))
        reflected = none if lobe == "transmission" else side(1.0)
        transmitted = none if lobe == "reflection" or not self.transmissive else side(-1.0)
        return jax.tree.map(jnp.add, reflected, transmitted)
