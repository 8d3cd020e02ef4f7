"""The whole model: metallic, opaque and transparent parts in one, under a clear coat if asked for."""

from typing import ClassVar

from ecfit._jax import jax, jnp
from ecfit.bsdf import option, parameter, register
from ecfit.enterprise.dielectric import HIGHEST_IOR, KINDS, Boundary
from ecfit.enterprise.energies import ENERGIES, ENERGY_DOC
from ecfit.enterprise.lobes import Lobe, Specular, schlick
from ecfit.errors import EcfitError
from ecfit.quadrature import Hemisphere, Measure, Total

Array = jax.Array

# F_c of the coat: an index of 1.5, fixed.
_COAT_F0 = 0.04


@register("enterprise-pbr")
class EnterprisePBR(Boundary):
    """Core, or Coated, of the Enterprise PBR Shading Model 2019x, isotropic and of one colour channel.

    blend = "merged" is the document's ThinCore or VolumetricCore, whose lobes share F_ms of the mixed F0 and
    F90; blend = "sum" is the sum of the three BSDFs that it stands for. f is the radiance BSDF.

    Raises `EcfitError` for a clear coat with exact energies.
    """

    alpha: Array = parameter(0.25, 0.0, 1.0, "GGX width; r = sqrt(alpha) is accepted too")
    rho: Array = parameter(1.0, 0.0, 1.0, "colour: of the metal, of the base, of what is transmitted")
    m: Array = parameter(0.0, 0.0, 1.0, "metallic")
    t: Array = parameter(0.0, 0.0, 1.0, "transparency")
    s: Array = parameter(1.0, 0.0, 1.0, "amount of specular reflection")
    ior: Array = parameter(1.5, 1.0, HIGHEST_IOR, "index of refraction of the denser side; F0 is accepted")
    rho_s: Array = parameter(1.0, 0.0, 1.0, "tint of the specular reflection at normal incidence")
    b: Array = parameter(0.0, 0.0, 1.0, "sheen of the base")
    c: Array = parameter(1.0, 0.0, 1.0, "strength of the clear coat (coat = clear)")
    alpha_c: Array = parameter(0.3, 0.0, 1.0, "the coat's roughness; its GGX width is the square")
    kind: str = option("thin", KINDS, "a sheet, or the boundary of a volume")
    side: str = option("entering", ("entering", "leaving"), "whether wo is outside or inside (volumetric)")
    blend: str = option("merged", ("merged", "sum"), "one core as printed, or the sum of three BSDFs")
    coat: str = option("none", ("none", "clear"), "a clear coat on top")
    energy: str = option("exact", ENERGIES, ENERGY_DOC)

    conserving: ClassVar[bool] = False

    def __check_init__(self) -> None:
        if self.coat == "clear" and self.energy == "exact":
            raise EcfitError(
                "a coated core is integrated over directions, each of which would need integrals of its own: "
                "choose energy = 'printed', 'tables' or 'none'"
            )

    def active_parameters(self) -> tuple[str, ...]:
        coat = ("c", "alpha_c") if self.coat == "clear" else ()
        return ("alpha", "rho", "m", "t", "s", "ior", "rho_s", "b", *coat)

    def lobes(self) -> tuple[tuple[Array, Lobe], ...]:
        """Of the core, without the coat."""
        layer, one = self.surface(), jnp.ones_like(self.s)
        dielectric = (1.0 - self.m) * self.s
        below = (
            (self.rho * (1.0 - self.m) * self.t, layer.transmitted(self.kind)),
            (self.rho * (1.0 - self.m) * (1.0 - self.t), layer.base(self.b)),
        )
        f0 = dielectric * layer.f0 + self.m * self.rho
        f90 = dielectric + self.m
        if self.kind == "thin":
            direct = ((one, Specular(self.alpha, schlick(f0, f90))),)
        else:
            direct = (
                (self.m, Specular(self.alpha, schlick(self.rho, one))),
                (dielectric, layer.reflected(self.kind, layer.f0, one)),
            )
        if self.blend == "merged":
            return (*direct, layer.multiple(one, f0, f90), *below)
        metal, rest = layer.multiple(self.m, self.rho, one), layer.multiple(dielectric, layer.f0, one)
        return (*direct, metal, rest, *below)

    def _coat(self) -> tuple[Array, Lobe]:
        f0 = jnp.full_like(self.c, _COAT_F0)
        return self.c, Specular(self.alpha_c * self.alpha_c, schlick(f0, jnp.ones_like(self.c)))

    def _core(self, wo: Array, wi: Array) -> Array:
        """What lies under the coat: Core (1 - c max(F_c(n.v), F_c(n.l)))."""
        least = jnp.minimum(jnp.abs(wo[2]), jnp.abs(wi[2]))
        factor = schlick(jnp.asarray(_COAT_F0), jnp.asarray(1.0))(least)
        return super().f(wo, wi) * (1.0 - self.c * factor)

    def f(self, wo: Array, wi: Array) -> Array:
        if self.coat == "none":
            return super().f(wo, wi)
        weight, coat = self._coat()
        return self._core(wo, wi) + weight * coat.f(wo, wi)

    def measure(self) -> Total:
        if self.coat == "none":
            return super().measure()
        weight, coat = self._coat()
        core: Measure = Hemisphere(self._core, True)
        return Total(((jnp.ones_like(self.c), core), (weight, coat)))
