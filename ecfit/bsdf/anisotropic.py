"""The rough conductor with two widths: anisotropic GGX."""

from typing import ClassVar

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, option, parameter
from ecfit.bsdf.registry import register
from ecfit.microfacet import Fresnel, SchlickFresnel, UnitFresnel
from ecfit.quadrature.anisotropic import AnisotropicReflection, stretched

Array = jax.Array

# Below, the turn of the lobe in azimuth is finer than the rules resolve.
_LEAST_ASPECT = 0.02


@register("anisotropic-conductor")
class AnisotropicConductor(BSDF):
    """F D G2 / (4 mu_o mu_i), D of widths alpha_u and alpha_v, height-correlated Smith (Heitz 2014).

    The widths are alpha and aspect x alpha. `phi` is the azimuth of wo from the direction of alpha_u, over a
    quarter turn (E is even in it, of period pi). azimuth = "averaged" is the mean over phi, of E and of f
    (over `AZIMUTHS` of them).
    """

    alpha: Array = parameter(0.25, 1e-4, 1.0, "GGX width along u; r = sqrt(alpha) is accepted too")
    aspect: Array = parameter(1.0, _LEAST_ASPECT, 1.0, "alpha_v / alpha_u, the square of r_v / r_u")
    phi: Array = parameter(0.0, 0.0, 1.5707963267948966, "azimuth of wo from u (azimuth = resolved)")
    F0: Array = parameter(1.0, 0.0, 1.0, "reflectance at normal incidence (fresnel = schlick)")
    F90: Array = parameter(1.0, 0.0, 1.0, "reflectance at grazing incidence (fresnel = schlick)")
    fresnel: str = option("unit", ("unit", "schlick"), "F = 1, or Schlick")
    azimuth: str = option("resolved", ("resolved", "averaged"), "of wo: one, or the mean over all")

    AZIMUTHS: ClassVar[int] = 16
    fresnel_parameters = ("F0", "F90")

    def active_parameters(self) -> tuple[str, ...]:
        azimuth = ("phi",) if self.azimuth == "resolved" else ()
        return ("alpha", "aspect", *azimuth, *(("F0", "F90") if self.fresnel == "schlick" else ()))

    def fresnel_factor(self) -> Fresnel:
        """F as a function of x = wo.h."""
        return SchlickFresnel(self.F0, self.F90) if self.fresnel == "schlick" else UnitFresnel()

    def f(self, wo: Array, wi: Array) -> Array:
        if self.azimuth == "resolved":
            return self._turned(wo, wi, self.phi)
        # Both signs: the mean over a whole turn.
        phi = 0.5 * jnp.pi * (jnp.arange(-self.AZIMUTHS, self.AZIMUTHS) + 0.5) / self.AZIMUTHS
        return jnp.mean(jax.vmap(lambda p: self._turned(wo, wi, p))(phi))

    def _turned(self, wo: Array, wi: Array, phi: Array) -> Array:
        """f with the surface turned so that wo, as given at azimuth 0, lies at phi from u."""
        above = (wo[2] > 0.0) & (wi[2] > 0.0)
        wi = jnp.where(above, wi, jnp.array([0.0, 0.0, 1.0]))
        c, s = jnp.cos(phi), jnp.sin(phi)
        o, i = ((c * w[0] - s * w[1], s * w[0] + c * w[1], w[2]) for w in (wo, wi))
        au, av = self.alpha, self.alpha * self.aspect
        h = tuple(a + b for a, b in zip(o, i, strict=True))
        length = jnp.sqrt(h[0] ** 2 + h[1] ** 2 + h[2] ** 2)
        # D: 1 / (pi au av ((h_x / au)^2 + (h_y / av)^2 + h_z^2)^2) of the unit h (Burley 2012).
        q = ((h[0] / au) ** 2 + (h[1] / av) ** 2 + h[2] ** 2) / length**2
        d = 1.0 / (jnp.pi * au * av * q * q)
        # G2 / (mu_o mu_i).
        g = 2.0 / (i[2] * stretched(au, av, o) + o[2] * stretched(au, av, i))
        x = jnp.minimum((o[0] * h[0] + o[1] * h[1] + o[2] * h[2]) / length, 1.0)
        return jnp.where(above, 0.25 * self.fresnel_factor()(x) * d * g, 0.0)

    def measure(self) -> AnisotropicReflection:
        count = self.AZIMUTHS if self.azimuth == "averaged" else 0
        return AnisotropicReflection(
            self.alpha, self.alpha * self.aspect, self.phi, self.fresnel_factor(), count
        )
