"""Microfacet reflection integrated over half vectors (see docs/conventions.md for the symbols).

With wi = reflect(wo, h), dwi = 4 x dh (x = wo.h), the albedo is the integral of
F(x) D(h) G2 x / mu_o over h. Polar angles of h with the azimuth phi measured from the plane of wo:

- the NDF's own rule in the slope T = tan(theta_h) / alpha removes the peak of D for every alpha;
- cos(theta_i) = 2 x cos(theta_h) - mu >= 0 bounds theta_h, for given phi, by pi/4 + delta/2 with
  delta = atan2(s cos(phi), mu): the domain ends in closed form and holds no kink;
- that edge turns within a width ~ mu around phi = pi/2: a sinh map centred there spreads it.

Everything per node is arithmetic and square roots; trigonometry is needed once per azimuth only.
"""

from typing import ClassVar

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDF, Fresnel, UnitFresnel, masking_shadowing
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import Estimate, graded, integrate

Array = jax.Array

# The sinh map's scale is mu, but not below this: at mu = 0 the integrand has a kink at phi = pi/2 in the
# middle of the map, whose contribution to the error falls with the square of the scale.
_SCALE_FLOOR = 1e-6
# Added to mu: makes mu = 0 the limit of small mu, and (alpha, mu) = (0, 0) a mirror's (E = F(0)).
_TINY = 1e-100
# Taken from mu, relatively: at mu = 1 the derivative of sin(theta_o) is infinite, though that of E is not.
_BELOW_ONE = 1e-13


def direction(mu: Array) -> tuple[Array, Array]:
    """mu = cos(theta_o), kept off 0 and 1, and s = sin(theta_o)."""
    mu = mu * (1.0 - _BELOW_ONE) + _TINY
    return mu, jnp.sqrt((1.0 - mu) * (1.0 + mu))


def azimuths(mu: Array, t: np.ndarray) -> tuple[Array, Array]:
    """cos(phi) and |dphi/dt|, t in [0, 1], for integrals over [0, 2 pi] of functions even in phi."""
    scale = jnp.maximum(mu, _SCALE_FLOOR)
    a = jnp.arcsinh(0.5 * jnp.pi / scale)
    b = a * (2.0 * t - 1.0)
    return jnp.sin(scale * jnp.sinh(b)), 4.0 * a * scale * jnp.cosh(b)


def horizon(mu: Array, s: Array, c: Array) -> tuple[Array, Array]:
    """tan(theta_max) = num / den where wi meets the horizon, for azimuths with cosine c."""
    b = s * c
    rho = jnp.sqrt(mu * mu + b * b)
    # (rho + b) / mu, for b < 0 as mu / (rho - b): neither cancels.
    return jnp.where(b > 0.0, rho + b, mu), jnp.where(b > 0.0, mu, rho - b)


class HalfVectorReflection(Measure):
    """The half-vector rule for f = F D G2 / (4 mu_o mu_i), for mu and alpha in [0, 1], both ends included.

    Convergence is geometric: see docs/performance.md for the errors of the levels.
    """

    ndf: NDF
    masking: str = eqx.field(static=True)
    alpha: Array
    fresnel: Fresnel

    default_level: ClassVar[int] = 1
    # The integrand is smooth by construction: nothing hides between the nodes.
    confirm: ClassVar[bool] = False
    # (nodes in slope, nodes in azimuth) of each level.
    ORDERS: ClassVar[tuple[tuple[int, int], ...]] = ((32, 24), (44, 36), (64, 52), (96, 80), (144, 120))
    # Least error estimate of each level. Near the normal GGX's coefficients fall algebraically, slower than
    # the decay that the estimate continues: over 18,000 random points of each of 4 variants the true error
    # exceeded it by 6e-10, 6e-11, 3e-11 and 4e-11 at most.
    FLOORS: ClassVar[tuple[float, ...]] = (2e-9, 2e-10, 8e-11, 8e-11, 2e-11)

    @property
    def levels(self) -> tuple[int, ...]:
        return tuple(a * b for a, b in self.ORDERS)

    def with_factor(self, factor: Fresnel) -> "HalfVectorReflection":
        """The same lobe with another function of x = wo.h in place of F."""
        return HalfVectorReflection(self.ndf, self.masking, self.alpha, factor)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return Estimate(jnp.zeros_like(mu), jnp.zeros_like(mu))
        slope, azimuth = (graded(0, count) for count in self.ORDERS[level])
        alpha, (mu, s) = self.alpha, direction(mu)
        c, jacobian = azimuths(mu, azimuth.nodes)
        num, den = horizon(mu, s, c)
        # Shapes below: (azimuth, slope).
        power, v = self.ndf.horizon_power, 1.0 - slope.nodes
        w_max = self.ndf.chart(num, alpha * den)[:, None]
        n, d, density = self.ndf.nodes(w_max * (1.0 - v**power))
        w = density * w_max * (power * v ** (power - 1))
        p = d * mu + alpha * n * (s * c)[:, None]  # x R
        r2 = d * d + (alpha * n) ** 2  # R^2, with cos(theta_h) = d / R
        mu_i = jnp.maximum(2.0 * p * d / r2 - mu, 0.0)
        g = masking_shadowing(self.ndf, self.masking, mu, mu_i, alpha) * mu_i
        x = jnp.minimum(p / jnp.sqrt(r2), 1.0)
        found = integrate(jacobian[:, None] * (self.fresnel(x) * g * p * w), azimuth, slope)
        return Estimate(found.value, jnp.maximum(found.error, self.FLOORS[level]))


class ThinInterface(Measure):
    """A sheet whose transmitted lobe is the reflected one mirrored, with 1 - F for F."""

    reflection: HalfVectorReflection

    default_level: ClassVar[int] = HalfVectorReflection.default_level
    confirm: ClassVar[bool] = HalfVectorReflection.confirm

    @property
    def levels(self) -> tuple[int, ...]:
        return self.reflection.levels

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        fresnel = self.reflection.fresnel
        factor = {"all": UnitFresnel(), "reflection": fresnel, "transmission": fresnel.complement()}[lobe]
        return self.reflection.with_factor(factor).albedo(mu, level, "reflection")
