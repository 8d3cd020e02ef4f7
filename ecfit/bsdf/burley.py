"""Burley's diffuse model: Schlick weights of both directions, and brighter backwards the rougher."""

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, parameter
from ecfit.bsdf.registry import register

Array = jax.Array

# 2 x the integrals of mu^(n+1) and mu^(n+1) (1 - mu)^5 over [0, 1], n = 0, 1, 2.
_PLAIN = (1.0, 2.0 / 3.0)
_WEIGHTED = (1.0 / 21.0, 1.0 / 84.0, 1.0 / 252.0)


@register("burley")
class Burley(BSDF):
    """rho / pi (1 + k (1 - mu_o)^5) (1 + k (1 - mu_i)^5), k = 2 r x^2 - 1/2, x = wi.h (Burley 2012).

    Reciprocal, but not conserving: rough and seen at grazing angles it reflects more than all.
    """

    r: Array = parameter(0.5, 0.0, 1.0, "perceptual roughness, sqrt(alpha) of the specular lobe above it")
    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance")

    conserving = False

    def f(self, wo: Array, wi: Array) -> Array:
        k = self.r * (1.0 + jnp.dot(wo, wi)) - 0.5  # 2 x^2 = 1 + wo.wi
        lobe = (1.0 + k * (1.0 - wo[2]) ** 5) * (1.0 + k * (1.0 - wi[2]) ** 5)
        return jnp.where(wi[2] > 0.0, self.rho / jnp.pi * lobe, 0.0)

    def exact_albedo(self, mu: Array) -> Array:
        """E(mu): a polynomial in mu and r, for f is one in both cosines and in the azimuth's."""
        weight = (1.0 - mu) ** 5
        base, slope = self.r - 0.5, self.r * mu  # k = base + slope mu_i + r s
        single = weight * (base * _PLAIN[0] + slope * _PLAIN[1]) + base * _WEIGHTED[0] + slope * _WEIGHTED[1]
        # The average of s^2 over the azimuth is (1 - mu_o^2) (1 - mu_i^2) / 2.
        square = base**2 * _WEIGHTED[0] + 2.0 * base * slope * _WEIGHTED[1] + slope**2 * _WEIGHTED[2]
        square = square + 0.5 * self.r**2 * (1.0 - mu * mu) * (_WEIGHTED[0] - _WEIGHTED[2])
        return self.rho * (1.0 + single + weight * square)
