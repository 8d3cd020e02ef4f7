"""A glossy layer whose specular lobe is compensated, alone or over a diffuse base."""

from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.approximation import Approximation
from ecfit.bsdf import BSDF, option, parameter, register
from ecfit.bsdf.microfacet import reflection
from ecfit.compensation.lookup import albedo_of
from ecfit.microfacet import (
    MASKINGS,
    NDFS,
    DielectricFresnel,
    Fresnel,
    SchlickDielectricFresnel,
    UnitFresnel,
)
from ecfit.quadrature import Estimate, HalfVectorReflection, Measure

Array = jax.Array

_INFINITY = float("inf")


class _LayerMeasure(Measure):
    """E_F / E_ss and what the base adds; approximations stand for the integrals where they are given."""

    model: "Glossy"

    default_level: ClassVar[int] = HalfVectorReflection.default_level
    confirm: ClassVar[bool] = HalfVectorReflection.confirm

    @property
    def levels(self) -> tuple[int, ...]:
        return self.model.lobe().levels

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        none = jnp.zeros_like(mu)
        if lobe == "transmission":
            return Estimate(none, none)
        model = self.model
        layer, single = (rule.albedo(mu, level, lobe) for rule in (model.lobe(), model.white_lobe()))
        given = albedo_of(model.single, model, mu)
        single = single if given is None else Estimate(given, none)
        layer = Estimate(
            layer.value / single.value,
            (layer.error + jnp.abs(layer.value / single.value) * single.error) / jnp.abs(single.value),
        )
        if model.base == "none":
            return layer
        given = albedo_of(model.layer, model, mu)
        if given is None:
            return Estimate(layer.value + (1.0 - layer.value) * model.rho, (1.0 - model.rho) * layer.error)
        return Estimate(layer.value + (1.0 - given) * model.rho, layer.error)


@register("glossy")
class Glossy(BSDF):
    """f = rho_ss / E_ss(mu_o) + (1 - E_spec(mu_o)) rho / pi (Sforza & Pellacini 2022, eq. 17 and 18).

    rho_ss is the microfacet reflection with its Fresnel factor, E_ss its albedo without, and
    E_spec = E_F / E_ss the albedo of the compensated layer, all integrated exactly. With base = "none" the
    diffuse term is left out, and the directional albedo is E_spec.

    F0 = 0 (no interface) gives E_spec = 0 and F0 = 1 gives 1. For every F0 > 0 E_spec -> 1 at grazing, so
    that F0 = 0 is a discontinuity.

    `single` and `layer` stand for E_ss and E_spec where they are given, as in a renderer.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX or Beckmann width; r = sqrt(alpha) is accepted too")
    ior: Array = parameter(1.5, 1.0, _INFINITY, "index of refraction of the layer; F0 is accepted")
    F90: Array = parameter(1.0, 0.0, 1.0, "reflectance at grazing incidence (fresnel = schlick)")
    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance of the base (base = diffuse)")
    ndf: str = option("ggx", tuple(NDFS), "distribution of normals")
    masking: str = option("separable", MASKINGS, "form of the masking-shadowing G2")
    fresnel: str = option("exact", ("exact", "schlick"), "exact, or Schlick with the F0 of ior")
    base: str = option("none", ("none", "diffuse"), "what lies under the layer")
    single: Approximation | None = eqx.field(static=True, default=None)
    layer: Approximation | None = eqx.field(static=True, default=None)

    # The factor 1 / E_ss depends on wo alone.
    reciprocal = False
    fresnel_parameters = ("ior", "F90")

    def active_parameters(self) -> tuple[str, ...]:
        names = ("alpha", "ior", "F90") if self.fresnel == "schlick" else ("alpha", "ior")
        return (*names, "rho") if self.base == "diffuse" else names

    def fresnel_factor(self) -> Fresnel:
        """F as a function of x = wo.h."""
        if self.fresnel == "schlick":
            return SchlickDielectricFresnel(self.ior, self.F90)
        return DielectricFresnel(self.ior)

    def lobe(self) -> HalfVectorReflection:
        """The rule for the specular lobe, not compensated."""
        return HalfVectorReflection(NDFS[self.ndf], self.masking, self.alpha, self.fresnel_factor())

    def white_lobe(self) -> HalfVectorReflection:
        """The same with F = 1."""
        return self.lobe().with_factor(UnitFresnel())

    def f(self, wo: Array, wi: Array) -> Array:
        mu, level = wo[2], HalfVectorReflection.default_level
        single = albedo_of(self.single, self, mu)
        if single is None:
            single = self.white_lobe().albedo(mu, level, "reflection").value
        value = reflection(self.ndf, self.masking, self.alpha, self.fresnel_factor(), wo, wi) / single
        if self.base == "none":
            return value
        layer = albedo_of(self.layer, self, mu)
        if layer is None:
            layer = self.lobe().albedo(mu, level, "reflection").value / single
        return value + jnp.where(wi[2] > 0.0, (1.0 - layer) * self.rho / jnp.pi, 0.0)

    def measure(self) -> Measure:
        return _LayerMeasure(self)
