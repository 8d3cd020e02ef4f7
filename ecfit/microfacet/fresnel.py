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

    def complement(self) -> "Fresnel":
        """1 - F: what passes."""
        return _Complement(self)


class _Complement(Fresnel):
    fresnel: Fresnel

    def __call__(self, x: Array) -> Array:
        return 1.0 - self.fresnel(x)


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


class F82TintFresnel(Fresnel):
    """Schlick's factor with F90 = 1, less b x (1 - x)^6: `tint` times Schlick's at x = 1/7, near 82 degrees.

    Kutz et al. 2021, Novel aspects of the Adobe Standard Material, section 2.3, as in OpenPBR. Not clipped:
    where tint is small, F is slightly below 0 on one side of x = 1/7.
    """

    F0: Array
    tint: Array

    def __call__(self, x: Array) -> Array:
        schlick = SchlickFresnel(self.F0, jnp.ones_like(self.F0))
        at = 1.0 / 7.0
        b = schlick(jnp.asarray(at)) * (1.0 - self.tint) / (at * (1.0 - at) ** 6)
        return schlick(x) - b * x * (1.0 - x) ** 6


def refracted_cosine(eta: Array, x: Array) -> tuple[Array, Array]:
    """cos(theta_t) by Snell's law at x = cos(theta), and whether there is a refracted ray.

    eta = n_transmitted / n_incident, infinity included; the cosine is 1 under total reflection.
    """
    e = 1.0 / eta
    # 1 - e^2 (1 - x^2) without cancellation at e = 1.
    c2 = (1.0 - e) * (1.0 + e) + (e * x) ** 2
    refracts = c2 > 0.0
    # The stand-in keeps the gradient of the root finite under total reflection.
    return jnp.sqrt(jnp.where(refracts, c2, 1.0)), refracts


class DielectricFresnel(Fresnel):
    """Exact unpolarised Fresnel of a dielectric, eta = n_transmitted / n_incident as seen by wo.

    Walter et al. 2007, eq. 22; 1 under total internal reflection (eta < 1, x^2 < 1 - eta^2) and for
    eta = infinity.
    """

    eta: Array

    def __call__(self, x: Array) -> Array:
        c, refracts = refracted_cosine(self.eta, x)
        e = 1.0 / self.eta
        # (e x - c) / (e x + c) with c^2 - e^2 x^2 = 1 - e^2: exactly 0 at eta = 1.
        # Divided twice: the square underflows in derivatives at grazing.
        sum_s = e * x + c
        s = (1.0 - e) * (1.0 + e) / sum_s / sum_s
        # 0 / 0 only for x = 0 and eta = infinity.
        sum_ = x + e * c
        regular = refracts & (sum_ > 0.0)
        p = (x - e * c) / jnp.where(regular, sum_, 1.0)
        return jnp.where(regular, 0.5 * (s * s + p * p), 1.0)


class SchlickDielectricFresnel(Fresnel):
    """Schlick's F0 + (F90 - F0) (1 - c)^5 for an interface, F0 = ((eta - 1) / (eta + 1))^2.

    c is the cosine in the less dense medium: x when entering, that of the refracted ray when leaving, where
    total reflection makes F = 1 (as renderers do it, e.g. Lagarde 2013).
    """

    eta: Array
    F90: Array

    def __call__(self, x: Array) -> Array:
        e = 1.0 / self.eta
        s = (1.0 - e) / (1.0 + e)
        c, refracts = refracted_cosine(self.eta, x)
        c = jnp.where(self.eta < 1.0, c, x)
        return jnp.where(refracts, s * s + (self.F90 - s * s) * (1.0 - c) ** 5, 1.0)


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
