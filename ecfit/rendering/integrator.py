"""The furnace's integrator: paths are sampled by the BSDF alone, and what they do is counted.

To be imported after `mitsuba.set_variant`.
"""

from typing import Any

from ecfit.rendering._mitsuba import mitsuba
from ecfit.rendering.verdict import LEAST_MU

mi, dr = mitsuba()

CHANNELS = ("inside", "light", "mu", "rest")


class Furnace(mi.SamplingIntegrator):
    """Light that reaches the camera under a constant light of radiance 1, path by path.

    At every scattering the BSDF is sampled `candidates` times, and one of these directions is taken with a
    probability in proportion to the energy that it carries; the path's weight is then that of their mean
    (resampled importance sampling: Talbot et al. 2005). It does not change the expectation; without it the
    weights of long paths inside rough glass, products of many factors of mean 1, scatter without bound.

    Beside the picture there are the channels `CHANNELS`, means over a pixel's samples: `inside`, 1 where
    mu >= LEAST_MU; and multiplied with it the light, mu, and `rest`: the energy of paths that were cut.
    """

    def __init__(self, props: Any) -> None:
        super().__init__(props)
        self.depth = props.get("depth", 64)
        self.candidates = props.get("candidates", 8)

    @dr.syntax
    def scatter(self, si: Any, bsdf: Any, sampler: Any, active: Any) -> Any:
        """A direction, the factor of its radiance and the relative index that it passed."""
        context = mi.BSDFContext()
        wo, eta, energy = mi.Vector3f(0.0, 0.0, 1.0), mi.Float(1.0), mi.Float(0.0)
        i = mi.UInt32(0)
        while i < self.candidates:
            sampled, value = bsdf.sample(
                context, si, sampler.next_1d(active), sampler.next_2d(active), active
            )
            # Radiance changes by eta^2 where it passes an interface.
            carried = value[0] * sampled.eta * sampled.eta
            energy = energy + carried
            taken = sampler.next_1d(active) * energy < carried
            wo = dr.select(taken, sampled.wo, wo)
            eta = dr.select(taken, sampled.eta, eta)
            i = i + 1
        return wo, energy / (self.candidates * eta * eta), eta

    @dr.syntax
    def sample(self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True) -> Any:
        ray = mi.Ray3f(ray)
        first = scene.ray_intersect(ray, active)
        hit = first.is_valid()
        mu = dr.select(hit, first.wi.z, 0.0)
        # The energy of a path is weight eta^2, with eta the index of where it is.
        weight, light, eta = mi.Float(1.0), mi.Float(0.0), mi.Float(1.0)
        depth = mi.UInt32(0)
        active = mi.Bool(active)
        while active:
            si = scene.ray_intersect(ray, active)
            light = dr.select(active & dr.isinf(si.t), weight, light)
            active = active & si.is_valid() & (depth < self.depth) & (weight > 0.0)
            if active:
                wo, factor, relative = self.scatter(si, si.bsdf(ray), sampler, active)
                weight = weight * factor
                eta = eta * relative
                ray = si.spawn_ray(si.to_world(wo))
                depth = depth + 1
        cut = dr.select(light > 0.0, 0.0, weight * eta * eta)
        inside = dr.select(hit & (mu >= LEAST_MU), mi.Float(1.0), mi.Float(0.0))
        return mi.Spectrum(light), True, [inside, inside * light, inside * mu, inside * cut]

    def aov_names(self) -> list[str]:
        return list(CHANNELS)


mi.register_integrator("ecfit-furnace", Furnace)
