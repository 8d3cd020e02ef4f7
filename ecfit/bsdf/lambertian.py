"""The Lambertian: the model with the simplest exact albedo."""

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, parameter
from ecfit.bsdf.registry import register

Array = jax.Array


@register("lambertian")
class Lambertian(BSDF):
    """f = rho / pi, with albedo rho for every mu."""

    rho: Array = parameter(1.0, 0.0, 1.0, "reflectance")

    def f(self, wo: Array, wi: Array) -> Array:
        return jnp.where(wi[2] > 0.0, self.rho / jnp.pi, 0.0)

    def exact_albedo(self, mu: Array) -> Array:
        return jnp.broadcast_to(self.rho, jnp.shape(mu))
