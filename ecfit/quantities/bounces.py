"""What the bounces after the first reflect, by the series of multiple scattering."""

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.errors import EcfitError
from ecfit.quadrature import Estimate
from ecfit.quantities.base import AverageAlbedo

Array = jax.Array


class MultipleBounces(AverageAlbedo):
    """S = F^2 E_avg / (1 - F (1 - E_avg)): multiple scattering relative to that of the white surface.

    Of what a bounce does not send out, 1 - E_avg, the next one reflects F and sends out F E_avg: the bounces
    k = 1, 2, ... after the first give F^(k + 1) (1 - E_avg)^k E_avg, and their sum is S (1 - E_avg) (Kulla &
    Conty 2017). F is the mean reflectance of a bounce, F_avg of a conductor and rho of diffuse facets,
    E_avg the average albedo of the same surface made white: `BSDF.per_bounce`.
    """

    def confirm(self, model: BSDF) -> bool:
        return True

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        bounce = model.per_bounce()
        if bounce is None:
            raise EcfitError(
                f"{type(model).__name__} does not say what a bounce reflects: multiple bounces are defined "
                "for models with per_bounce(), such as 'conductor' and 'qon'"
            )
        white, reflectance = bounce
        average = super().estimate(white, mu, level)
        absorbed = 1.0 - reflectance * (1.0 - average.value)
        # A white surface at E_avg = 0 sends nothing out however often it reflects; the limit F -> 1 is 1.
        absorbed = jnp.where(absorbed > 0.0, absorbed, 1.0)
        value = reflectance * reflectance * average.value / absorbed
        slope = reflectance * reflectance * (1.0 - reflectance) / (absorbed * absorbed)
        return Estimate(value, jnp.abs(slope) * average.error)
