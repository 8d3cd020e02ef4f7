"""Rough conductors: one microfacet reflection lobe."""

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, option, parameter
from ecfit.bsdf.microfacet import reflection
from ecfit.bsdf.registry import register
from ecfit.microfacet import (
    MASKINGS,
    NDFS,
    ConductorFresnel,
    F82TintFresnel,
    Fresnel,
    SchlickFresnel,
    UnitFresnel,
)
from ecfit.quadrature import HalfVectorReflection
from ecfit.quadrature.rules import gauss_legendre

Array = jax.Array

# Schlick's factor needs 16 for its 28 degrees in t; complex indices of metals are good to 1e-12 with these.
_AVERAGE_NODES = 48


@register("conductor")
class Conductor(BSDF):
    """f = F(wo.h) D(h) G2(wo, wi) / (4 mu_o mu_i) (Sforza & Pellacini 2022, eq. 15, times Fresnel).

    With fresnel="unit" this is the single-scattering lobe whose albedo E_ss normalises energy
    compensation (their eq. 14).
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX or Beckmann width; r = sqrt(alpha) is accepted too")
    F0: Array = parameter(1.0, 0.0, 1.0, "reflectance at normal incidence (fresnel = schlick, f82-tint)")
    F90: Array = parameter(1.0, 0.0, 1.0, "reflectance at grazing incidence (fresnel = schlick)")
    tint: Array = parameter(1.0, 0.0, 1.0, "part of Schlick's factor at 82 degrees (fresnel = f82-tint)")
    eta: Array = parameter(0.2, 0.01, 20.0, "real part of the index of refraction (fresnel = exact)")
    k: Array = parameter(3.9, 0.0, 30.0, "imaginary part of the index of refraction (fresnel = exact)")
    ndf: str = option("ggx", tuple(NDFS), "distribution of normals")
    masking: str = option("separable", MASKINGS, "form of the masking-shadowing G2")
    fresnel: str = option(
        "unit", ("unit", "schlick", "f82-tint", "exact"), "F = 1, Schlick, F82 tint, or complex index"
    )

    fresnel_parameters = ("F0", "F90", "tint", "eta", "k")

    def active_parameters(self) -> tuple[str, ...]:
        by_fresnel = {"schlick": ("F0", "F90"), "f82-tint": ("F0", "tint"), "exact": ("eta", "k")}
        return ("alpha", *by_fresnel.get(self.fresnel, ()))

    def fresnel_factor(self) -> Fresnel:
        """F as a function of x = wo.h."""
        if self.fresnel == "schlick":
            return SchlickFresnel(self.F0, self.F90)
        if self.fresnel == "f82-tint":
            return F82TintFresnel(self.F0, self.tint)
        if self.fresnel == "exact":
            return ConductorFresnel(self.eta, self.k)
        return UnitFresnel()

    def per_bounce(self) -> tuple[BSDF, Array]:
        """The surface with F = 1, and F_avg = 2 x integral of F(x) x over [0, 1] (Kulla & Conty 2017)."""
        # x = t^4: a metal of small k falls fast near grazing, as a root.
        t, weight = (jnp.asarray(v) for v in gauss_legendre(_AVERAGE_NODES))
        white = Conductor(alpha=self.alpha, ndf=self.ndf, masking=self.masking)
        return white, weight @ (8.0 * t**7 * self.fresnel_factor()(t**4))

    def f(self, wo: Array, wi: Array) -> Array:
        return reflection(self.ndf, self.masking, self.alpha, self.fresnel_factor(), wo, wi)

    def measure(self) -> HalfVectorReflection:
        return HalfVectorReflection(NDFS[self.ndf], self.masking, self.alpha, self.fresnel_factor())
