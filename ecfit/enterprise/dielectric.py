"""The dielectric BSDFs: an opaque one over a diffuse base, and a transparent one, thin or a boundary."""

from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import option, parameter, register
from ecfit.enterprise.base import Base
from ecfit.enterprise.energies import ENERGIES, ENERGY_DOC, Albedos
from ecfit.enterprise.lobes import (
    BoundaryReflection,
    Lobe,
    MultipleScattering,
    Refraction,
    Specular,
    ThinTransmission,
    schlick,
)
from ecfit.enterprise.metallic import Lobes
from ecfit.microfacet import Fresnel
from ecfit.microfacet.fresnel import refracted_cosine

Array = jax.Array

KINDS = ("thin", "volumetric")
HIGHEST_IOR = 100.0


def normal_reflectance(ior: Array) -> Array:
    """F0 = ((ior - 1) / (ior + 1))^2."""
    root = (ior - 1.0) / (ior + 1.0)
    return root * root


class BoundaryFresnel(Fresnel):
    """F_d(f0, f90) at a boundary: Schlick's factor of the angle in the less dense medium (Lagarde 2013).

    1 under total reflection, whatever f0 and f90.
    """

    f0: Array
    f90: Array
    eta: Array

    def __call__(self, x: Array) -> Array:
        c, refracts = refracted_cosine(self.eta, x)
        c = jnp.where(self.eta < 1.0, c, x)
        return jnp.where(refracts, schlick(self.f0, self.f90)(c), 1.0)


class Scaled(Fresnel):
    """s F: so that 1 - s F passes."""

    fresnel: Fresnel
    scale: Array

    def __call__(self, x: Array) -> Array:
        return self.scale * self.fresnel(x)


class Surface(eqx.Module):
    """What the dielectrics share, resolved: the roughness, f0 = F0 rho_s, s, and the boundary's index.

    Attributes:
        leaving: whether wo is inside the denser medium.
    """

    alpha: Array
    ior: Array
    f0: Array
    s: Array
    energy: str = eqx.field(static=True)
    leaving: bool = eqx.field(static=True, default=False)

    @property
    def albedos(self) -> Albedos:
        """Where E_m and E come from, at f0."""
        return Albedos(self.alpha, self.f0, self.energy)

    @property
    def eta(self) -> Array:
        """n_transmitted / n_incident as seen by wo."""
        return 1.0 / self.ior if self.leaving else self.ior

    @property
    def critical(self) -> Array:
        """Cosine of the critical angle seen from inside; 0 from outside."""
        square = 1.0 - 1.0 / (self.ior * self.ior)
        root = jnp.sqrt(jnp.where(square > 0.0, square, 1.0))
        return jnp.where(square > 0.0, root, 0.0) if self.leaving else jnp.zeros_like(self.ior)

    def multiple(self, weight: Array, f0: Array, f90: Array) -> tuple[Array, Lobe]:
        """weight M_r,ms F_ms(f0, f90)."""
        factor = self.albedos.F_ms(f0, f90, MultipleScattering.default_level)
        return weight * factor, MultipleScattering(self.albedos)

    def reflected(self, kind: str, f0: Array, f90: Array) -> Lobe:
        """M_r F for a sheet, M_r F_d at a boundary."""
        if kind == "thin" or not self.leaving:
            return Specular(self.alpha, schlick(f0, f90))
        return BoundaryReflection(self.alpha, self.eta, BoundaryFresnel(f0, f90, self.eta), self.leaving)

    def transmitted(self, kind: str) -> Lobe:
        """M_t' (1 - s F(f0, 1))."""
        one = jnp.ones_like(self.f0)
        if kind == "thin":
            return ThinTransmission(self.alpha, Scaled(schlick(self.f0, one), self.s).complement())
        fresnel = Scaled(BoundaryFresnel(self.f0, one, self.eta), self.s)
        return Refraction(self.alpha, self.eta, fresnel, self.leaving)

    def base(self, b: Array) -> Lobe:
        """B, without rho."""
        return Base(self.albedos, self.s, b, self.critical)


_ALPHA = "GGX width; r = sqrt(alpha) is accepted too"
_IOR = "index of refraction of the denser side; F0 is accepted"


class Boundary(Lobes):
    """A model with light on both sides: a sheet (`kind` is "thin"), or the boundary of a volume."""

    alpha: eqx.AbstractVar[Array]
    ior: eqx.AbstractVar[Array]
    rho_s: eqx.AbstractVar[Array]
    s: eqx.AbstractVar[Array]
    kind: eqx.AbstractVar[str]
    side: eqx.AbstractVar[str]
    energy: eqx.AbstractVar[str]

    transmissive = True

    def surface(self) -> Surface:
        """The dielectric part."""
        leaving = self.kind == "volumetric" and self.side == "leaving"
        f0 = normal_reflectance(self.ior) * self.rho_s
        return Surface(self.alpha, self.ior, f0, self.s, self.energy, leaving)

    def relative_ior(self) -> Array:
        return jnp.ones_like(self.ior) if self.kind == "thin" else self.surface().eta

    def albedo_kinks(self) -> Array:
        surface = self.surface()
        return surface.critical[None] if surface.leaving else jnp.zeros(0)


@register("enterprise-opaque")
class Opaque(Lobes):
    """rho B + s M_r F(F0 rho_s, 1) + s M_r,ms F_ms(F0 rho_s, 1) (Enterprise PBR 2019x, opaque dielectric)."""

    alpha: Array = parameter(0.25, 0.0, 1.0, _ALPHA)
    ior: Array = parameter(1.5, 1.0, jnp.inf, _IOR)
    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance of the base")
    s: Array = parameter(1.0, 0.0, 1.0, "amount of specular reflection")
    rho_s: Array = parameter(1.0, 0.0, 1.0, "tint of the specular reflection at normal incidence")
    b: Array = parameter(0.0, 0.0, 1.0, "sheen of the base")
    energy: str = option("exact", ENERGIES, ENERGY_DOC)

    conserving: ClassVar[bool] = False

    def surface(self) -> Surface:
        """The specular layer."""
        return Surface(self.alpha, self.ior, normal_reflectance(self.ior) * self.rho_s, self.s, self.energy)

    def lobes(self) -> tuple[tuple[Array, Lobe], ...]:
        layer, one = self.surface(), jnp.ones_like(self.s)
        return (
            (self.rho, layer.base(self.b)),
            (self.s, layer.reflected("thin", layer.f0, one)),
            layer.multiple(self.s, layer.f0, one),
        )


@register("enterprise-transparent")
class Transparent(Boundary):
    """s M_r F_d + rho M_t' (1 - s F_d) + s M_r,ms F_ms (Enterprise PBR 2019x, transparent dielectric).

    kind = "thin" mirrors the reflected lobe below the surface, "volumetric" refracts; f is the radiance BSDF.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, _ALPHA)
    ior: Array = parameter(1.5, 1.0, HIGHEST_IOR, _IOR)
    rho: Array = parameter(1.0, 0.0, 1.0, "colour of what is transmitted")
    s: Array = parameter(1.0, 0.0, 1.0, "amount of specular reflection")
    rho_s: Array = parameter(1.0, 0.0, 1.0, "tint of the specular reflection at normal incidence")
    kind: str = option("thin", KINDS, "a sheet, or the boundary of a volume")
    side: str = option("entering", ("entering", "leaving"), "whether wo is outside or inside (volumetric)")
    energy: str = option("exact", ENERGIES, ENERGY_DOC)

    conserving: ClassVar[bool] = False

    def lobes(self) -> tuple[tuple[Array, Lobe], ...]:
        layer, one = self.surface(), jnp.ones_like(self.s)
        return (
            (self.s, layer.reflected(self.kind, layer.f0, one)),
            (self.rho, layer.transmitted(self.kind)),
            layer.multiple(self.s, layer.f0, one),
        )
