"""The metallic BSDF: the microfacet lobe with Schlick's factor and its multiple scattering."""

import abc
from typing import ClassVar

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, option, parameter, register
from ecfit.enterprise.energies import ENERGIES, ENERGY_DOC, Albedos
from ecfit.enterprise.lobes import Lobe, MultipleScattering, Specular, schlick
from ecfit.microfacet import Fresnel
from ecfit.quadrature import Total

Array = jax.Array


class Lobes(BSDF):
    """A model that is a weighted sum of lobes; what it is a sum of is all that a subclass says."""

    @abc.abstractmethod
    def lobes(self) -> tuple[tuple[Array, Lobe], ...]:
        """(weight, lobe) pairs; the weights do not depend on directions."""

    def f(self, wo: Array, wi: Array) -> Array:
        (weight, first), *rest = self.lobes()
        value = weight * first.f(wo, wi)
        for weight, lobe in rest:
            value = value + weight * lobe.f(wo, wi)
        return value

    def measure(self) -> Total:
        return Total(self.lobes())


@register("enterprise-metallic")
class Metallic(Lobes):
    """M_r F(F0, F90) + M_r,ms F_ms(F0, F90) (Enterprise PBR 2019x, Metallic BSDF).

    With energy = "exact" the albedo at F90 = 1 is E(mu), the layer over the document's diffuse base, and at
    F0 = F90 = 1 it is 1.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX width; r = sqrt(alpha) is accepted too")
    F0: Array = parameter(0.9, 0.0, 1.0, "reflectance at normal incidence, the document's rho")
    F90: Array = parameter(1.0, 0.0, 1.0, "reflectance at grazing incidence")
    energy: str = option("exact", ENERGIES, ENERGY_DOC)

    # Printed fits leave [0, 1], and their averages are not those of their directional albedos.
    conserving: ClassVar[bool] = False
    fresnel_parameters = ("F0", "F90")

    def albedos(self) -> Albedos:
        """Where E_m and the rest come from."""
        return Albedos(self.alpha, self.F0, self.energy)

    def fresnel_factor(self) -> Fresnel:
        """F as a function of x = wo.h."""
        return schlick(self.F0, self.F90)

    def lobes(self) -> tuple[tuple[Array, Lobe], ...]:
        albedos = self.albedos()
        level = MultipleScattering.default_level
        return (
            (jnp.ones_like(self.F0), Specular(self.alpha, self.fresnel_factor())),
            (albedos.F_ms(self.F0, self.F90, level), MultipleScattering(albedos)),
        )
