"""The reflection lobe itself, direction by direction: for models whose f is an integral, and for its fits."""

from collections.abc import Mapping
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.errors import EcfitError
from ecfit.quadrature import Estimate
from ecfit.quantities.base import Quantity

Array = jax.Array


class Brdf(Quantity):
    """f(wo, wi) in 1/sr of an isotropic reflection, with error estimate.

    Coordinates: mu and mu_i, cosines of wo and wi, and cos_phi, the cosine of the azimuth between them, in
    [-1, 1] (1: wi on wo's side of the normal). Azimuths equidistant in phi are Chebyshev nodes of cos_phi.

    Attributes:
        cosine: 1 for f mu_i, the radiance that a beam of unit irradiance across itself makes; 0 for f.

    Raises `EcfitError` for a `cosine` other than 0 and 1, and for the transmitted lobe.
    """

    cosine: int = eqx.field(static=True, default=0)

    coordinates: ClassVar[tuple[str, ...]] = ("mu", "mu_i", "cos_phi")

    def __check_init__(self) -> None:
        if self.cosine not in (0, 1) or isinstance(self.cosine, bool):
            raise EcfitError(f"cosine must be 0 (f) or 1 (f mu_i), got {self.cosine!r}")
        if self.lobe == "transmission":
            raise EcfitError("the quantity 'brdf' is of reflection: lobe must be all or reflection")

    def options(self) -> dict[str, int]:
        return {"cosine": self.cosine}

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        return model.value_levels

    def bounded(self, model: BSDF) -> bool:
        return False

    def confirm(self, model: BSDF) -> bool:
        return False

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        raise EcfitError("the quantity 'brdf' needs the coordinates mu, mu_i and cos_phi")

    def estimate_at(self, model: BSDF, point: Mapping[str, Array], level: int) -> Estimate:
        mu, mu_i, c = (point[name] for name in self.coordinates)
        s_o, s_i = (jnp.sqrt(jnp.maximum((1.0 - m) * (1.0 + m), 0.0)) for m in (mu, mu_i))
        wo = jnp.stack([s_o, jnp.zeros_like(mu), mu])
        wi = jnp.stack([s_i * c, s_i * jnp.sqrt(jnp.maximum((1.0 - c) * (1.0 + c), 0.0)), mu_i])
        found = model.value(wo, wi, level)
        return jax.tree.map(lambda v: mu_i * v, found) if self.cosine else found
