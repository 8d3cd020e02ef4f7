"""The lobes that the Enterprise PBR model is a sum of: values and rules."""

import abc
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf.microfacet import reflection, refraction
from ecfit.enterprise.energies import MASKING, Albedos, remaining, specular_rule
from ecfit.microfacet import NDFS, Fresnel, SchlickFresnel, UnitFresnel
from ecfit.quadrature import Estimate, HalfVectorReflection, Interface, Measure

Array = jax.Array


class Lobe(Measure):
    """One lobe: its value f(wo, wi), beside the rule for its albedo."""

    default_level: ClassVar[int] = HalfVectorReflection.default_level
    confirm: ClassVar[bool] = False

    @abc.abstractmethod
    def f(self, wo: Array, wi: Array) -> Array:
        """Radiance BSDF of unit vectors of shape (3,), without the cosine."""


def _none(mu: Array) -> Estimate:
    return Estimate(jnp.zeros_like(mu), jnp.zeros_like(mu))


class Specular(Lobe):
    """M_r F on the side of wo."""

    alpha: Array
    fresnel: Fresnel

    @property
    def levels(self) -> tuple[int, ...]:
        return specular_rule(self.alpha, self.fresnel).levels

    def f(self, wo: Array, wi: Array) -> Array:
        return reflection("ggx", MASKING, self.alpha, self.fresnel, wo, wi)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return _none(mu)
        return specular_rule(self.alpha, self.fresnel).albedo(mu, level, "reflection")


class ThinTransmission(Specular):
    """M_r(v, l') F on the other side, l' mirrored at the surface: a sheet that does not bend light."""

    def f(self, wo: Array, wi: Array) -> Array:
        return super().f(wo, wi * jnp.array([1.0, 1.0, -1.0]))

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "reflection":
            return _none(mu)
        return super().albedo(mu, level, "reflection")


class _AtInterface(Lobe):
    """A lobe of a boundary of two media."""

    alpha: Array
    eta: Array
    fresnel: Fresnel
    leaving: bool = eqx.field(static=True)

    def _rule(self, fresnel: Fresnel) -> Interface:
        return Interface(NDFS["ggx"], MASKING, self.alpha, self.eta, fresnel, self.leaving)

    @property
    def levels(self) -> tuple[int, ...]:
        return self._rule(self.fresnel).levels


class BoundaryReflection(_AtInterface):
    """M_r F_d, where F_d = 1 under total reflection."""

    def f(self, wo: Array, wi: Array) -> Array:
        return reflection("ggx", MASKING, self.alpha, self.fresnel, wo, wi)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        return (
            _none(mu) if lobe == "transmission" else self._rule(self.fresnel).albedo(mu, level, "reflection")
        )


class Refraction(_AtInterface):
    """M_t (1 - F); the albedo is that of the radiance BSDF, as `Interface` has it."""

    def f(self, wo: Array, wi: Array) -> Array:
        return refraction("ggx", MASKING, self.alpha, self.fresnel, self.eta, wo, wi)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        return (
            _none(mu) if lobe == "reflection" else self._rule(self.fresnel).albedo(mu, level, "transmission")
        )


class MultipleScattering(Lobe):
    """M_r,ms: (1 - E_m(v)) (1 - E_m(l)) / (pi (1 - E_m,avg)), without F_ms."""

    albedos: Albedos

    @property
    def levels(self) -> tuple[int, ...]:
        nodes = specular_rule(self.albedos.alpha, UnitFresnel()).levels
        return tuple(n * max(self.albedos.integrals, 1) for n in nodes)

    def f(self, wo: Array, wi: Array) -> Array:
        level = self.default_level
        rest, lost = remaining(self.albedos.single_average(level).value)
        above = (wo[2] > 0.0) & (wi[2] > 0.0)
        o, i = (self.albedos.single(jnp.where(above, w[2], 1.0), level).value for w in (wo, wi))
        return jnp.where(above, lost * (1.0 - o) * (1.0 - i) / (jnp.pi * rest), 0.0)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return _none(mu)
        single = self.albedos.single(mu, level)
        if self.albedos.energy == "none":
            return _none(mu)
        if self.albedos.energy == "exact":  # the mean is the average: all comes back
            return Estimate(1.0 - single.value, single.error)
        mean = self.albedos.single_mean(level)
        rest, lost = remaining(self.albedos.single_average(level).value)
        share = lost / rest
        return Estimate(
            (1.0 - single.value) * (1.0 - mean.value) * share,
            jnp.abs((1.0 - single.value) * share) * mean.error,
        )


def schlick(f0: Array, f90: Array) -> SchlickFresnel:
    """F(f0, f90) of the document, exponent 5."""
    return SchlickFresnel(f0, f90)
