"""Compensated materials as Mitsuba BSDFs: Mitsuba's own microfacet plugins, scaled by 1 / E.

Nothing of a lobe is written here: GGX, its visible normals, the separable masking and the exact Fresnel
equations are those of `roughconductor` and `roughdielectric`. In Mitsuba `si.wi` is the direction of the path
towards the camera, our wo; the albedos are taken at its mu and on its side.

To be imported after `mitsuba.set_variant`: the classes derive from those of the variant.
"""

from collections.abc import Callable
from typing import Any

from ecfit.rendering._mitsuba import mitsuba

mi, dr = mitsuba()

Array = Any
# mu in [0, 1] -> E, at one alpha and one ior.
Albedo = Callable[[Array], Array]


def turquin_factor(E: Array, F0: Array = 1.0) -> Array:
    """1 + F0 (1 - E) / E, as `ecfit.compensation.turquin_factor`, whose package loads JAX."""
    return 1.0 + F0 * (1.0 - E) / E


def _one(mu: Array) -> Array:
    return mu * 0.0 + 1.0


def _mirrored(v: Array) -> Array:
    return mi.Vector3f(v.x, v.y, -v.z)


def _upward(v: Array) -> Array:
    return mi.Vector3f(v.x, v.y, dr.abs(v.z))


class _Made(mi.BSDF):
    """A BSDF made in Python, of parts that are objects, not of a dictionary."""

    def _declare(self, *flags: Any) -> None:
        whole = flags[0]
        for flag in flags[1:]:
            whole = whole | flag
        self.m_components = list(flags)
        self.m_flags = whole

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def to_string(self) -> str:
        return type(self).__name__


class Scaled(_Made):
    """base (1 + F0 (1 - E) / E), E that of the side (Sforza & Pellacini 2022, eq. 13 and 19).

    Args:
        base: a Mitsuba BSDF.
        outside, inside: the albedo for the camera's side and the other.
        F0: 1, or a colour.
    """

    def __init__(self, base: Any, outside: Albedo, inside: Albedo = _one, F0: Any = 1.0) -> None:
        super().__init__(mi.Properties())
        self.base, self.outside, self.inside, self.F0 = base, outside, inside, F0
        self._declare(*(base.flags(i) for i in range(base.component_count())))

    def factor(self, si: Any) -> Any:
        z = si.wi.z
        mu = dr.abs(z)
        return turquin_factor(dr.select(z > 0.0, self.outside(mu), self.inside(mu)), self.F0)

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        sampled, weight = self.base.sample(ctx, si, sample1, sample2, active)
        return sampled, weight * self.factor(si)

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.base.eval(ctx, si, wo, active) * self.factor(si)

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.base.pdf(ctx, si, wo, active)


class Layered(_Made):
    """specular / E_ss + (1 - E_spec) rho / pi (eq. 18); with E_spec = F(mu) the uncompensated eq. 16.

    Args:
        specular: Mitsuba's rough reflection with the Fresnel factor of the layer.
        single: E_ss.
        layer: E_spec, what the layer keeps from the base.
        rho: reflectance of the base, a colour.
    """

    def __init__(self, specular: Any, single: Albedo, layer: Albedo, rho: Any) -> None:
        super().__init__(mi.Properties())
        self.specular, self.single, self.layer, self.rho = specular, single, layer, rho
        front = mi.BSDFFlags.FrontSide
        self._declare(mi.BSDFFlags.GlossyReflection | front, mi.BSDFFlags.DiffuseReflection | front)

    def _share(self, mu: Any) -> Any:
        """Probability of the specular lobe; never 0 or 1, as both lobes reach everywhere."""
        return dr.clip(self.layer(mu), 0.05, 0.95)

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        share = self._share(si.wi.z)
        sampled, _ = self.specular.sample(ctx, si, sample1 / share, sample2, active)
        diffuse = sample1 >= share
        wo = dr.select(diffuse, mi.warp.square_to_cosine_hemisphere(sample2), sampled.wo)
        density = self.pdf(ctx, si, wo, active)
        seen = active & (density > 0.0)
        value = self.eval(ctx, si, wo, seen)
        out = mi.BSDFSample3f()
        out.wo = wo
        out.pdf = dr.select(seen, density, 0.0)
        out.eta = mi.Float(1.0)
        out.sampled_component = dr.select(diffuse, mi.UInt32(1), mi.UInt32(0))
        out.sampled_type = dr.select(
            diffuse,
            mi.UInt32(+mi.BSDFFlags.DiffuseReflection),
            mi.UInt32(+mi.BSDFFlags.GlossyReflection),
        )
        return out, dr.select(seen, value / dr.select(seen, density, 1.0), mi.Spectrum(0.0))

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        mu, mu_i = si.wi.z, wo.z
        above = active & (mu > 0.0) & (mu_i > 0.0)
        specular = self.specular.eval(ctx, si, wo, above) * turquin_factor(self.single(mu))
        base = self.rho * ((1.0 - self.layer(mu)) * mu_i * dr.inv_pi)
        return dr.select(above, specular + base, mi.Spectrum(0.0))

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        above = active & (si.wi.z > 0.0) & (wo.z > 0.0)
        share = self._share(si.wi.z)
        density = share * self.specular.pdf(ctx, si, wo, above) + (1.0 - share) * wo.z * dr.inv_pi
        return dr.select(above, density, 0.0)


class Thin(_Made):
    """A sheet that does not bend light: F reflected, 1 - F mirrored below, both over E_ss (section 3.4).

    Args:
        white: Mitsuba's rough reflection with F = 1.
        ior: of the sheet.
        single: E_ss.
    """

    def __init__(self, white: Any, ior: Any, single: Albedo) -> None:
        super().__init__(mi.Properties())
        self.white, self.ior, self.single = white, ior, single
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self._declare(mi.BSDFFlags.GlossyReflection | sides, mi.BSDFFlags.GlossyTransmission | sides)

    def _fresnel(self, wi: Any, wo: Any) -> Any:
        """F at the facet between two directions above."""
        return mi.fresnel(dr.dot(wi, dr.normalize(wi + wo)), self.ior)[0]

    def _above(self, si: Any) -> Any:
        """The same with si.wi above: both sides of the sheet are alike."""
        out = mi.SurfaceInteraction3f(si)
        out.wi = _upward(si.wi)
        return out

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        above = self._above(si)
        sampled, weight = self.white.sample(ctx, above, sample1, sample2, active)
        seen = active & (sampled.pdf > 0.0)
        reflected = dr.select(seen, self._fresnel(above.wi, sampled.wo), 1.0)
        passes = sample1 >= reflected
        sampled.pdf = sampled.pdf * dr.select(passes, 1.0 - reflected, reflected)
        sampled.wo = dr.select(passes == (si.wi.z > 0.0), _mirrored(sampled.wo), sampled.wo)
        sampled.sampled_component = dr.select(passes, mi.UInt32(1), mi.UInt32(0))
        sampled.sampled_type = dr.select(
            passes, mi.UInt32(+mi.BSDFFlags.GlossyTransmission), mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        )
        weight = weight * turquin_factor(self.single(above.wi.z))
        return sampled, dr.select(seen, weight, mi.Spectrum(0.0))

    def _split(self, si: Any, wo: Any) -> tuple[Any, Any, Any]:
        """(interaction, wo, part of the light) of the reflection that stands for either lobe."""
        above, up = self._above(si), _upward(wo)
        reflected = self._fresnel(above.wi, up)
        return above, up, dr.select(si.wi.z * wo.z > 0.0, reflected, 1.0 - reflected)

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        above, up, part = self._split(si, wo)
        return self.white.eval(ctx, above, up, active) * (part * turquin_factor(self.single(above.wi.z)))

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        above, up, part = self._split(si, wo)
        return self.white.pdf(ctx, above, up, active) * part


def _rough(plugin: str, alpha: float, **more: Any) -> Any:
    settings = {"type": plugin, "distribution": "ggx", "alpha": alpha, "sample_visible": True, **more}
    return mi.load_dict(settings)


def _rgb(values: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(v) for v in values]}


def _normal_reflectance(eta: Any, k: Any) -> Any:
    """F0 of a conductor for each colour."""
    return mi.Color3f(*(((n - 1) ** 2 + m**2) / ((n + 1) ** 2 + m**2) for n, m in zip(eta, k, strict=True)))


def make(sphere: Any, albedos: dict[str, Albedo]) -> Any:
    """The BSDF of a sphere.

    Args:
        sphere: model, alpha, ior, eta, k and rho (`ecfit.rendering.sphere.Sphere`).
        albedos: role -> E(mu); empty for the uncompensated material.
    """
    alpha, ior = sphere.alpha, sphere.ior
    single = albedos.get("conductor", _one)
    if sphere.model == "conductor":
        if sphere.eta is None:
            return Scaled(_rough("roughconductor", alpha, material="none"), single)
        base = _rough("roughconductor", alpha, eta=_rgb(sphere.eta), k=_rgb(sphere.k))
        return Scaled(base, single, F0=_normal_reflectance(sphere.eta, sphere.k))
    if sphere.model == "glossy":
        # The Fresnel equations of a conductor with k = 0 are those of a dielectric.
        base = _rough("roughconductor", alpha, eta=float(ior), k=0.0)
        layer = albedos.get("glossy", lambda mu: mi.fresnel(mu, ior)[0])
        return Layered(base, single, layer, mi.Color3f(sphere.rho))
    if sphere.model == "thin-dielectric":
        return Thin(_rough("roughconductor", alpha, material="none"), mi.Float(ior), single)
    base = _rough("roughdielectric", alpha, int_ior=float(ior), ext_ior=1.0)
    return Scaled(base, albedos.get("entering", _one), albedos.get("leaving", _one))
