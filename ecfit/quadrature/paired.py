"""The albedo of an isotropic reflection without a peak, given by cosines and azimuth."""

from collections.abc import Callable
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import Estimate, graded, integrate

Array = jax.Array

# Stands for mu = 0: the limit is taken along mu_o.
_HORIZON = 1e-12


class PairedHemisphere(Measure):
    """Gauss-Legendre in mu_i = t^3 and the azimuth, of a smooth lobe whose values are integrals themselves.

    Attributes:
        value: f with its own error estimate at (mu_o, mu_i, cos_phi, level).
        costs: evaluations that one value takes at each of its levels.
    """

    value: Callable[[Array, Array, Array, int], Estimate]
    costs: tuple[int, ...] = eqx.field(static=True)

    default_level: ClassVar[int] = 1
    # (nodes in mu_i, nodes in azimuth, level of f).
    ORDERS: ClassVar[tuple[tuple[int, int, int], ...]] = ((10, 6, 0), (16, 10, 1), (26, 16, 2), (40, 24, 3))

    @property
    def levels(self) -> tuple[int, ...]:
        return tuple(a * b * self.costs[level] for a, b, level in self.ORDERS)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return Estimate(jnp.zeros_like(mu), jnp.zeros_like(mu))
        polar, azimuth = (graded(0, count) for count in self.ORDERS[level][:2])
        mu = jnp.maximum(mu, _HORIZON)
        t = jnp.asarray(polar.nodes)
        mu_i, cos_phi = t**3, jnp.cos(jnp.pi * jnp.asarray(azimuth.nodes))

        def value(m: Array, c: Array) -> Estimate:
            return self.value(mu, m, c, self.ORDERS[level][2])

        found = jax.vmap(jax.vmap(value, (None, 0)), (0, None))(mu_i, cos_phi)
        weight = (2.0 * jnp.pi * 3.0 * t**5)[:, None]
        whole = integrate(found.value * weight, polar, azimuth)
        own = jnp.asarray(polar.weights) @ (found.error * weight) @ jnp.asarray(azimuth.weights)
        return Estimate(whole.value, whole.error + own)
