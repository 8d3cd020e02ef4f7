"""The general rule: any f(wo, wi), over the hemispheres of wi."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import graded

Array = jax.Array


class Hemisphere(Measure):
    """Gauss-Legendre panels in (theta_i, phi), graded towards the mirror direction.

    Panels halve towards theta_i = theta_o and phi = pi (for transmission: the straight-through
    direction), so that a lobe around it is resolved down to a width of about pi 2^-depth. A BSDF that
    peaks elsewhere or has discontinuities converges slowly and its entries say so.

    Attributes:
        f: the BSDF value f(wo, wi) of unit vectors of shape (3,), without the cosine.
        transmissive: whether f is to be integrated over the lower hemisphere at all.
    """

    f: Callable[[Array, Array], Array]
    transmissive: bool = True

    # (dyadic depth, nodes per panel and dimension) of each level.
    ORDERS: ClassVar[tuple[tuple[int, int], ...]] = ((0, 8), (0, 12), (1, 12), (2, 14), (4, 14), (6, 18), (9, 20))

    @property
    def levels(self) -> tuple[int, ...]:
        return tuple(4 * ((depth + 1) * count) ** 2 for depth, count in self.ORDERS)

    def albedo(self, mu: Array, level: int, lobe: str) -> Array:
        depth, count = self.ORDERS[level]
        x, w = graded(depth, count)
        theta_o = jnp.arccos(jnp.clip(mu, 0.0, 1.0))
        wo = jnp.stack([jnp.sin(theta_o), jnp.zeros_like(mu), mu])
        # theta_i in [0, theta_o] and [theta_o, pi/2], both graded towards theta_o.
        below, above = theta_o * x, (0.5 * jnp.pi - theta_o) * x
        theta = jnp.concatenate([theta_o - below, theta_o + above])
        w_theta = jnp.concatenate([theta_o * w, (0.5 * jnp.pi - theta_o) * w])
        phi = np.pi * np.concatenate([1.0 + x, 1.0 - x])
        w_phi = np.pi * np.concatenate([w, w])
        sin, cos = jnp.sin(theta), jnp.cos(theta)

        def side(sign: float) -> Array:
            def value(sin_i: Array, cos_i: Array, p: Array) -> Array:
                return self.f(wo, jnp.stack([sin_i * jnp.cos(p), sin_i * jnp.sin(p), sign * cos_i]))

            over_phi = jax.vmap(value, (None, None, 0))
            values = jax.vmap(over_phi, (0, 0, None))(sin, cos, jnp.asarray(phi))
            return (w_theta * sin * cos) @ (values @ w_phi)

        if lobe == "reflection" or (lobe == "all" and not self.transmissive):
            return side(1.0)
        if not self.transmissive:
            return jnp.zeros_like(mu)
        return side(-1.0) if lobe == "transmission" else side(1.0) + side(-1.0)
