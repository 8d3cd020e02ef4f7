"""The Fresnel factor of a facet as a quantity: formulas for it are judged and fitted like any other."""

from typing import ClassVar

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.errors import EcfitError
from ecfit.quadrature import Estimate
from ecfit.quantities.base import Quantity

Array = jax.Array

# Rounding of the exact formulas, which divide sums without cancellation.
_ROUNDING = 1e-15


class FacetFresnel(Quantity):
    """F(mu): the model's Fresnel factor at mu = wo.h. It is a formula, and does not depend on roughness."""

    coordinates: ClassVar[tuple[str, ...]] = ("mu",)

    def parameters(self, model: BSDF) -> tuple[str, ...]:
        return tuple(n for n in model.active_parameters() if n != "alpha")

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        return (1,)

    def confirm(self, model: BSDF) -> bool:
        return False

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        fresnel = getattr(model, "fresnel_factor", None)
        if fresnel is None:
            raise EcfitError(f"{type(model).__name__} has no Fresnel factor")
        value = fresnel()(mu)
        return Estimate(value, jnp.full_like(value, _ROUNDING))
