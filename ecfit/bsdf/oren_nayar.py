"""Rough diffuse reflection: qualitative Oren-Nayar, Fujii's, and EON, which keeps all energy.

All three are rho / pi (A + B s / t) with s = wo.wi - mu_o mu_i; EON adds what is lost. Equation numbers are
those of Portsmouth et al. 2024. Albedos have closed forms, written so that nothing cancels at grazing angles
and slopes are finite at normal incidence.
"""

import math
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, parameter
from ecfit.bsdf.registry import register

Array = jax.Array

# 1 / A - 1 of Fujii's model at full roughness: what a black surface at grazing incidence lacks.
FUJII_LOSS = 0.5 - 2.0 / (3.0 * math.pi)
# B's weight in the averages of the models, eq. 9 and 15.
_QON_AVERAGE = 2.0 / 3.0 - 64.0 / (45.0 * math.pi)
_FON_AVERAGE = 2.0 / 3.0 - 28.0 / (15.0 * math.pi)


def _sine(mu: Array) -> Array:
    """sqrt(1 - mu^2), with the slope 0 at mu = 1."""
    inside = mu < 1.0
    root = jnp.sqrt((1.0 - jnp.where(inside, mu, 0.0)) * (1.0 + mu))
    return jnp.where(inside, root, 0.0)


def fujii_deficit(mu: Array) -> Array:
    """pi (1/2 - 2 / (3 pi)) - G_F(mu) >= 0, G_F of eq. 13: 0 at mu = 0, where its slope is 1.

    1 - E of Fujii's model is this times B / pi. mu in [0, 1], any shape.
    """
    mu = jnp.asarray(mu)
    inside = mu < 1.0
    c = jnp.where(inside, mu, 0.0)
    s = jnp.sqrt((1.0 - c) * (1.0 + c))
    # pi / 2 - s theta = (pi / 2) (1 - s) + s asin(mu), and 1 - s = mu^2 / (1 + s): nothing cancels.
    grazing = (0.5 * math.pi - 2.0 / 3.0) * c * c / (1.0 + s)
    value = grazing + s * (jnp.arcsin(c) + s * c - (2.0 / 3.0) * c * (1.0 + s + s * s) / (1.0 + s))
    return jnp.where(inside, value, 0.5 * math.pi - 2.0 / 3.0)


def fujii_g(mu: Array) -> Array:
    """G_F(mu), eq. 13: the integral of s / t_F over the hemisphere, cosine included."""
    return math.pi * FUJII_LOSS - fujii_deficit(mu)


def qualitative_g(mu: Array) -> Array:
    """G_q(mu), eq. 8: the integral of s / t_q over the hemisphere, cosine included; pi / 2 at mu = 0."""
    return fujii_g(mu) + (2.0 / 3.0) * _sine(jnp.asarray(mu))


def _shape(wo: Array, wi: Array, behind: float) -> tuple[Array, Array]:
    """s / t and whether wi is above: s / max(mu_o, mu_i) on the viewer's side, else `behind` times s."""
    above = wi[2] > 0.0
    s = wo[0] * wi[0] + wo[1] * wi[1]
    largest = jnp.where(above, jnp.maximum(wo[2], wi[2]), 1.0)
    return jnp.where(s > 0.0, s / largest, behind * s), above


class _OrenNayar(BSDF):
    """What the three have in common: s changes its sign, where f bends, at right angles to the view."""

    fresnel_parameters = ("rho",)
    rho: eqx.AbstractVar[Array]
    azimuths: ClassVar[tuple[float, ...]] = (0.5 * math.pi,)

    def per_bounce(self) -> tuple[BSDF, Array]:
        """The surface with rho = 1, and rho."""
        return self.with_parameters({"rho": jnp.ones_like(self.rho)}), self.rho

    def albedo_kinks(self) -> Array:
        # E has the term (1 - mu)^(1/2) or (1 - mu)^(3/2).
        return jnp.ones(1)


@register("oren-nayar")
@register("qon")
class QualitativeOrenNayar(_OrenNayar):
    """QON: rho / pi (A + B s / t) with t = max(mu_o, mu_i) for s > 0, else nothing (eq. 1 to 4).

    Reciprocal, but not conserving: E(0) exceeds 1 for sigma in (0, 0.33). Also named `oren-nayar`.
    """

    sigma: Array = parameter(0.5, 0.0, 0.5 * math.pi, "standard deviation of the facets' slope angle in rad")
    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance of the facets")

    conserving = False

    def factors(self) -> tuple[Array, Array]:
        """A and B (below eq. 1)."""
        square = self.sigma * self.sigma
        return 1.0 - 0.5 * square / (square + 0.33), 0.45 * square / (square + 0.09)

    def f(self, wo: Array, wi: Array) -> Array:
        a, b = self.factors()
        shape, above = _shape(wo, wi, 0.0)
        return jnp.where(above, self.rho / jnp.pi * (a + b * shape), 0.0)

    def exact_albedo(self, mu: Array) -> Array:
        """E(mu), eq. 5 with eq. 8."""
        a, b = self.factors()
        return self.rho * (a + b / jnp.pi * qualitative_g(mu))

    def exact_average(self) -> Array:
        """E_avg, eq. 9."""
        a, b = self.factors()
        return self.rho * (a + b * _QON_AVERAGE)


class _Fujii(_OrenNayar):
    """The parameters and albedos of Fujii's single-scattering model."""

    diffuse_roughness: Array = parameter(
        0.5, 0.0, 1.0, "weight of the Oren-Nayar shape, 0 is Lambert; the source's r, but no root of an alpha"
    )
    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance of the facets")

    def _white(self, wo: Array, wi: Array) -> tuple[Array, Array]:
        """pi f at rho = 1 (eq. 10), and whether wi is above."""
        shape, above = _shape(wo, wi, 1.0)
        return self._a() * (1.0 + self.diffuse_roughness * shape), above

    def _a(self) -> Array:
        """A_F (below eq. 11)."""
        return 1.0 / (1.0 + FUJII_LOSS * self.diffuse_roughness)

    def _lost(self, mu: Array) -> Array:
        """1 - E(mu) at rho = 1, eq. 12."""
        return self._a() * self.diffuse_roughness / math.pi * fujii_deficit(mu)

    def _average(self) -> Array:
        """E_avg at rho = 1, eq. 15."""
        return self._a() * (1.0 + _FON_AVERAGE * self.diffuse_roughness)


@register("fon")
class FujiiOrenNayar(_Fujii):
    """FON: rho A / pi (1 + r s / t) with t = max(mu_o, mu_i) for s > 0, else 1 (eq. 10 and 11)."""

    def f(self, wo: Array, wi: Array) -> Array:
        white, above = self._white(wo, wi)
        return jnp.where(above, self.rho / jnp.pi * white, 0.0)

    def exact_albedo(self, mu: Array) -> Array:
        """E(mu), eq. 12 and 13."""
        return self.rho * (1.0 - self._lost(mu))

    def exact_average(self) -> Array:
        """E_avg, eq. 15."""
        return self.rho * self._average()


@register("eon")
class EnergyPreservingOrenNayar(_Fujii):
    """EON: FON and a lobe of its lost energy (eq. 16 to 19); white at rho = 1, more saturated than rho below.

    The lobe is Kulla and Conty's with the closed albedos of FON and F_avg = rho:
    `ecfit.compensate("fon", method="kulla-conty", F_ms=...)` is the same function. 1 - E is proportional to
    the roughness, which cancels here once, so that no epsilon is needed at 0.
    """

    def _multiple(self) -> Array:
        """Albedo of the lobe over 1 - E(mu): rho^2 E_avg / (1 - rho (1 - E_avg)) (eq. 18)."""
        average = self._average()
        return self.rho * self.rho * average / (1.0 - self.rho * (1.0 - average))

    def f(self, wo: Array, wi: Array) -> Array:
        white, above = self._white(wo, wi)
        up = jnp.where(above, wi[2], 1.0)
        lost = self._lost(wo[2]) * fujii_deficit(up) / (math.pi * (FUJII_LOSS - _FON_AVERAGE))
        return jnp.where(above, (self.rho * white + self._multiple() * lost) / jnp.pi, 0.0)

    def exact_albedo(self, mu: Array) -> Array:
        """E(mu), eq. 12 and 20."""
        lost = self._lost(mu)
        return self.rho * (1.0 - lost) + self._multiple() * lost

    def exact_average(self) -> Array:
        """The average of eq. 12 and 20."""
        average = self._average()
        return self.rho * average + self._multiple() * (1.0 - average)
