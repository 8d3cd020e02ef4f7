"""Rough dielectrics: a microfacet reflection and refraction lobe, and the thin sheet without refraction."""

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, option, parameter
from ecfit.bsdf.microfacet import reflection, refraction
from ecfit.bsdf.registry import register
from ecfit.microfacet import (
    INTERFACE_MASKINGS,
    MASKINGS,
    NDFS,
    DielectricFresnel,
    Fresnel,
    SchlickDielectricFresnel,
)
from ecfit.quadrature import HalfVectorReflection, Interface, ThinInterface

Array = jax.Array

# Far beyond any dielectric, so that a table may show the limit; infinity would leave no transmitted ray.
_HIGHEST_IOR = 100.0


def _fresnel(kind: str, eta: Array, f90: Array) -> Fresnel:
    return SchlickDielectricFresnel(eta, f90) if kind == "schlick" else DielectricFresnel(eta)


@register("dielectric")
class Dielectric(BSDF):
    """Reflection F and refraction 1 - F at a rough interface (Sforza & Pellacini 2022, eq. 19 to 23).

    f is the radiance BSDF: its transmitted lobe integrates to T / eta^2. As ior -> 1 the albedo goes to the
    masking G1(mu), not to 1: see docs/conventions.md before dividing by it.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX or Beckmann width; r = sqrt(alpha) is accepted too")
    ior: Array = parameter(1.5, 1.0, _HIGHEST_IOR, "index of refraction of the denser side; F0 is accepted")
    F90: Array = parameter(1.0, 0.0, 1.0, "reflectance at grazing incidence (fresnel = schlick)")
    side: str = option("entering", ("entering", "leaving"), "whether wo is outside or inside")
    ndf: str = option("ggx", tuple(NDFS), "distribution of normals")
    masking: str = option("separable", INTERFACE_MASKINGS, "form of the masking-shadowing G2")
    fresnel: str = option("exact", ("exact", "schlick"), "exact, or Schlick with the F0 of ior")

    transmissive = True
    fresnel_parameters = ("ior", "F90")

    def active_parameters(self) -> tuple[str, ...]:
        return ("alpha", "ior", "F90") if self.fresnel == "schlick" else ("alpha", "ior")

    def relative_ior(self) -> Array:
        return self.ior if self.side == "entering" else 1.0 / self.ior

    def fresnel_factor(self) -> Fresnel:
        """F as a function of x = wo.h."""
        return _fresnel(self.fresnel, self.relative_ior(), self.F90)

    def albedo_kinks(self) -> Array:
        # The critical cosine, where total reflection begins for a smooth surface.
        square = 1.0 - 1.0 / (self.ior * self.ior)
        root = jnp.sqrt(jnp.where(square > 0.0, square, 1.0))
        return jnp.where(square > 0.0, root, 0.0)[None] if self.side == "leaving" else jnp.zeros(0)

    def f(self, wo: Array, wi: Array) -> Array:
        lobe = self.ndf, self.masking, self.alpha, self.fresnel_factor()
        return reflection(*lobe, wo, wi) + refraction(*lobe, self.relative_ior(), wo, wi)

    def measure(self) -> Interface:
        return Interface(
            NDFS[self.ndf],
            self.masking,
            self.alpha,
            self.relative_ior(),
            self.fresnel_factor(),
            leaving=self.side == "leaving",
        )


@register("thin-dielectric")
class ThinDielectric(BSDF):
    """A sheet that does not bend light: the transmitted lobe is the reflected one, mirrored below.

    Its R + T is the albedo of a white conductor, whatever the Fresnel factor (Sforza & Pellacini 2022,
    section 3.4). F is that of one interface: light between the two faces is left out.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX or Beckmann width; r = sqrt(alpha) is accepted too")
    ior: Array = parameter(1.5, 1.0, _HIGHEST_IOR, "index of refraction of the sheet; F0 is accepted")
    F90: Array = parameter(1.0, 0.0, 1.0, "reflectance at grazing incidence (fresnel = schlick)")
    ndf: str = option("ggx", tuple(NDFS), "distribution of normals")
    masking: str = option("separable", MASKINGS, "form of the masking-shadowing G2")
    fresnel: str = option("exact", ("exact", "schlick"), "exact, or Schlick with the F0 of ior")

    transmissive = True
    fresnel_parameters = ("ior", "F90")

    def active_parameters(self) -> tuple[str, ...]:
        return ("alpha", "ior", "F90") if self.fresnel == "schlick" else ("alpha", "ior")

    def fresnel_factor(self) -> Fresnel:
        """F as a function of x = wo.h."""
        return _fresnel(self.fresnel, self.ior, self.F90)

    def f(self, wo: Array, wi: Array) -> Array:
        lobe = self.ndf, self.masking, self.alpha
        factor = self.fresnel_factor()
        mirrored = wi * jnp.array([1.0, 1.0, -1.0])
        return reflection(*lobe, factor, wo, wi) + reflection(*lobe, factor.complement(), wo, mirrored)

    def measure(self) -> ThinInterface:
        return ThinInterface(
            HalfVectorReflection(NDFS[self.ndf], self.masking, self.alpha, self.fresnel_factor())
        )
