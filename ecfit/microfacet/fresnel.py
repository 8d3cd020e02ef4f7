"""Fresnel factors: the reflected part F(x) at a microfacet, x = wo.h in [0, 1]."""

import abc

import equinox as eqx

from ecfit._jax import jax, jnp

Array = jax.Array


class Fresnel(eqx.Module):
    """A reflectance as a function of x = wo.h."""

    @abc.abstractmethod
    def __call__(self, x: Array) -> Array:
        """Reflectance in [0, 1] at x in [0, 1]."""


class UnitFresnel(Fresnel):
    """F = 1: a white conductor, the normaliser of energy compensation."""

    def __call__(self, x: Array) -> Array:
        return jnp.ones_like(x)


class SchlickFresnel(Fresnel):
    """F0 + (F90 - F0) (1 - x)^exponent (Schlick 1994, eq. 15, with a free F90)."""

    F0: Array
    F90: Array
    exponent: int = eqx.field(static=True, default=5)

    def __call__(self, x: Array) -> Array:
        return self.F0 + (self.F90 - self.F0) * (1.0 - x) ** self.exponent


class DielectricFresnel(Fresnel):
    """Exact unpolarised Fresnel of a dielectric, eta = n_transmitted / n_incident as seen by wo.

    Walter et al. 2007, eq. 22; 1 under total internal reflection (eta < 1, x^2 < 1 - eta^2).
    """

    eta: Array

    def __call__(self, x: Array) -> Array:
        t2 = self.eta * self.eta - (1.0 - x) * (1.0 + x)
        refracts = t2 > 0.0
        # g = eta cos(theta_t); the inner `where` keeps the gradient of the root finite under TIR.
        g = jnp.sqrt(jnp.where(refracts, t2, 1.0))
        # (g - x)/(g + x) with g^2 - x^2 = eta^2 - 1: exactly 0 at eta = 1.
        s = (self.eta * self.eta - 1.0) / (g + x) ** 2
        n2 = self.eta * self.eta
        p = (n2 * x - g) / (n2 * x + g)
        return jnp.where(refracts, 0.5 * (s * s + p * p), 1.0)


class ConductorFresnel(Fresnel):
    """Exact unpolarised Fresnel of a conductor with complex index eta + i k, seen from vacuum.

    Born & Wolf 1999, section 14.2, in the real form of e.g. Gulbrandsen 2014, eq. 1-2.
    """

    eta: Array
    k: Array

    def __call__(self, x: Array) -> Array:
        s2 = (1.0 - x) * (1.0 + x)
        d = self.eta * self.eta - self.k * self.k - s2
        h2 = jnp.sqrt(d * d + 4.0 * self.eta * self.eta * self.k * self.k)
        a = jnp.sqrt(jnp.maximum(0.5 * (h2 + d), 1e-300))
        rs = (h2 + x * x - 2.0 * a * x) / (h2 + x * x + 2.0 * a * x)
        rp = (x * x * h2 + s2 * s2 - 2.0 * a * x * s2) / (x * x * h2 + s2 * s2 + 2.0 * a * x * s2)
        return 0.5 * rs * (1.0 + rp)
