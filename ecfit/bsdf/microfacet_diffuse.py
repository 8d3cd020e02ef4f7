"""Microfacet diffuse: Lambertian facets under GGX, with what each facet's Fresnel lets in and out."""

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, option, parameter
from ecfit.bsdf.registry import register
from ecfit.microfacet import MASKINGS, NDFS, masking_shadowing
from ecfit.quadrature import Estimate, FacetPairs, PairedHemisphere

Array = jax.Array

# Makes the albedo of a smooth surface rho (1 - F0): 2 x integral of (1 - (1 - x)^5) x dx = 20 / 21.
_NORMALISED = 21.0 / 20.0


def schlick_pair(x_o: Array, x_i: Array) -> Array:
    """Gotanda 2014, eq. 6, of one facet without its constant factors."""
    return (1.0 - (1.0 - x_o) ** 5) * (1.0 - (1.0 - x_i) ** 5)


def _unit(x_o: Array, x_i: Array) -> Array:
    return jnp.ones_like(x_o)


@register("microfacet-diffuse")
class MicrofacetDiffuse(BSDF):
    """rho / (pi mu_o mu_i) x integral of (m.wo)+ (m.wi)+ D(m) F_diff G2 over normals m (Gotanda 2014, eq. 4).

    F_diff = 21/20 (1 - F0) (1 - (1 - m.wo)^5) (1 - (1 - m.wi)^5) (eq. 6 at each facet; Shirley et al. 1997);
    with fresnel = "unit" facets are plain Lambertians, F_diff = 1. G2 is Smith's, of the directions alone.
    The source's sigma is alpha (docs/systems/gotanda.md). Light that bounces between facets is lost.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX or Beckmann width; r = sqrt(alpha) is accepted too")
    F0: Array = parameter(
        0.0, 0.0, 1.0, "specular reflectance of a facet at normal incidence (fresnel = schlick)"
    )
    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance of what lies below the facets")
    ndf: str = option("ggx", tuple(NDFS), "distribution of normals")
    masking: str = option("height-correlated", MASKINGS, "form of the masking-shadowing G2")
    fresnel: str = option("schlick", ("schlick", "unit"), "what a facet lets in and out: eq. 6, or all")

    def active_parameters(self) -> tuple[str, ...]:
        return ("alpha", "F0", "rho") if self.fresnel == "schlick" else ("alpha", "rho")

    @property
    def _facets(self) -> FacetPairs:
        return FacetPairs(NDFS[self.ndf], self.alpha, schlick_pair if self.fresnel == "schlick" else _unit)

    @property
    def value_levels(self) -> tuple[int, ...]:
        return self._facets.levels

    def value(self, wo: Array, wi: Array, level: int) -> Estimate:
        """f with the error estimate of its integral over normals."""
        above = (wo[2] > 0.0) & (wi[2] > 0.0)
        mu_o, mu_i = (jnp.where(above, jnp.minimum(w[2], 1.0), 1.0) for w in (wo, wi))
        sines = (1.0 - mu_o * mu_o) * (1.0 - mu_i * mu_i)
        # Along the normal there is no azimuth, and any serves.
        turned = sines > 1e-28
        across = (wo[0] * wi[0] + wo[1] * wi[1]) / jnp.sqrt(jnp.where(turned, sines, 1.0))
        cos_phi = jnp.clip(jnp.where(turned, across, 0.0), -1.0, 1.0)
        found = self.at(mu_o, mu_i, cos_phi, level)
        return jax.tree.map(lambda v: jnp.where(above, v, 0.0), found)

    def at(self, mu_o: Array, mu_i: Array, cos_phi: Array, level: int) -> Estimate:
        """f by cosines of the polar angles, in [0, 1], and of the azimuth between the directions."""
        integral = self._facets.integral(mu_o, mu_i, cos_phi, level)
        factor = self.rho / jnp.pi * masking_shadowing(NDFS[self.ndf], self.masking, mu_o, mu_i, self.alpha)
        if self.fresnel == "schlick":
            factor = factor * _NORMALISED * (1.0 - self.F0)
        return jax.tree.map(lambda v: factor * v, integral)

    def f(self, wo: Array, wi: Array) -> Array:
        return self.value(wo, wi, 1).value

    def measure(self) -> PairedHemisphere:
        return PairedHemisphere(self.at, self.value_levels)
