"""Distributions of microfacet normals (NDFs) that keep their shape when alpha scales the slopes.

With tan(theta_h) = alpha T, both D and Smith's Lambda depend on alpha through T alone, so one rule in T
serves every alpha, and the peak of a small alpha disappears from the integrand.
"""

import abc
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp

Array = jax.Array


class NDF(eqx.Module):
    """A shape-invariant isotropic distribution of normals."""

    @abc.abstractmethod
    def D(self, cos_theta: Array, alpha: Array) -> Array:
        """Density of normals per steradian and unit area at cos(theta_h) in (0, 1]; alpha > 0."""

    @abc.abstractmethod
    def mu_lambda(self, mu: Array, alpha: Array) -> Array:
        """mu Lambda(mu): finite and smooth down to mu = 0 and alpha = 0, where Lambda itself is not."""

    # The integrals below have nodes clustered with this power at the horizon of wi, where masking leaves a
    # boundary layer (the best of 2, 3, 4 for 12 to 48 nodes).
    horizon_power: ClassVar[int]

    @abc.abstractmethod
    def chart(self, num: Array, den: Array) -> Array:
        """The coordinate w, from w = 0 at T = 0, of the slope T = num / den (den = 0: infinity).

        In w the integrals of D over slopes are smooth up to their end; `nodes` is the inverse.
        """

    @abc.abstractmethod
    def nodes(self, w: Array) -> tuple[Array, Array, Array]:
        """(n, d, density) with T = n / d at w, such that for any smooth g

        integral of g(T) D cos(theta_h) sin(theta_h) dtheta_h = integral of g(n / d) d density dw.
        The azimuth is left to the caller. (The factor d is left out of the density because the
        integrand's x / cos(theta_h) brings a 1 / d.)
        """


class GGX(NDF):
    """Trowbridge-Reitz (Walter et al. 2007, eq. 33 and 34)."""

    horizon_power: ClassVar[int] = 3

    def D(self, cos_theta: Array, alpha: Array) -> Array:
        c2 = cos_theta * cos_theta
        # sin^2 + alpha^2 cos^2 written without cancellation near the normal.
        d = (1.0 - cos_theta) * (1.0 + cos_theta) + alpha * alpha * c2
        return alpha * alpha / (jnp.pi * d * d)

    def mu_lambda(self, mu: Array, alpha: Array) -> Array:
        a2 = alpha * alpha
        g2 = a2 + (1.0 - a2) * mu * mu
        # The root's derivative is infinite only at mu = alpha = 0: keep gradients finite there.
        g = jnp.where(g2 > 0.0, jnp.sqrt(jnp.where(g2 > 0.0, g2, 1.0)), 0.0)
        return 0.5 * (g - mu)

    def chart(self, num: Array, den: Array) -> Array:
        # T = tan(psi) = 2 w / (1 - w^2) with w = tan(psi / 2): rational in w up to T = infinity (w = 1).
        length = num * num + den * den
        safe = length > 0.0
        return jnp.where(safe, num / (den + jnp.sqrt(jnp.where(safe, length, 1.0))), 0.0)

    def nodes(self, w: Array) -> tuple[Array, Array, Array]:
        # D cos sin dtheta = sin(psi) cos(psi) dpsi / pi.
        q = 1.0 / (1.0 + w * w)
        return 2.0 * w, (1.0 - w) * (1.0 + w), (4.0 / jnp.pi) * w * q * q * q


class Beckmann(NDF):
    """Beckmann (Walter et al. 2007, eq. 25; Lambda in closed form: Heitz 2014, eq. 72)."""

    horizon_power: ClassVar[int] = 2
    # exp(-T^2) is below 1e-19 here: the rest of the integral is under the rounding error of 64 bits.
    T_CUT = 6.6

    def D(self, cos_theta: Array, alpha: Array) -> Array:
        c2 = cos_theta * cos_theta
        a2 = alpha * alpha
        t2 = (1.0 - cos_theta) * (1.0 + cos_theta) / c2
        return jnp.exp(-t2 / a2) / (jnp.pi * a2 * c2 * c2)

    def mu_lambda(self, mu: Array, alpha: Array) -> Array:
        s2 = (1.0 - mu) * (1.0 + mu)
        t = alpha * jnp.where(s2 > 0.0, jnp.sqrt(jnp.where(s2 > 0.0, s2, 1.0)), 0.0)
        # Beyond a = 26 exp(-a^2) and erfc(a) underflow. The inner `where` keeps derivatives finite there.
        small = mu < 26.0 * t
        a = jnp.where(small, mu / jnp.where(small, t, 1.0), 26.0)
        gauss = t * jnp.exp(-a * a) / (2.0 * jnp.sqrt(jnp.pi))
        return jnp.maximum(gauss - 0.5 * mu * jax.scipy.special.erfc(a), 0.0)

    def chart(self, num: Array, den: Array) -> Array:
        # Where T is beyond the cut, integrals end at the cut; the switch costs nothing visible because the
        # integrand is below rounding there.
        return jnp.where(num < self.T_CUT * den, num / jnp.where(den > 0.0, den, 1.0), self.T_CUT)

    def nodes(self, w: Array) -> tuple[Array, Array, Array]:
        return w, jnp.ones_like(w), w * jnp.exp(-w * w) / jnp.pi


NDFS: dict[str, NDF] = {"ggx": GGX(), "beckmann": Beckmann()}
