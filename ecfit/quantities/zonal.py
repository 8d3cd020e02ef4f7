"""Zonal-harmonic moments of the lobe (1 - E) mu: what a smooth environment sends into multiple scattering."""

from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.errors import EcfitError
from ecfit.harmonics.zonal import zonal_harmonic
from ecfit.quantities.base import CosineIntegral

Array = jax.Array


class ZonalMoment(CosineIntegral):
    """E_l = 2 pi x integral of Y_l0(mu) (1 - E(mu)) mu dmu over [0, 1] (MSBRDF blog, Mayaux 2018 part 2).

    Y_l0 is the orthonormal zonal harmonic of degree l. E_0 = sqrt(pi) / 2 x (1 - E_avg); moments of degree 2
    and more may be negative.

    Attributes:
        degree: l, 0..32.

    Raises `EcfitError` for a degree outside its range.
    """

    # Beyond, the nodes of the lower levels no longer resolve the oscillations of Y_l0.
    HIGHEST: ClassVar[int] = 32

    degree: int = eqx.field(static=True, default=0)

    def __check_init__(self) -> None:
        whole = isinstance(self.degree, int) and not isinstance(self.degree, bool)
        if not whole or not 0 <= self.degree <= self.HIGHEST:
            raise EcfitError(f"degree must be an integer in 0..{self.HIGHEST}, got {self.degree!r}")

    def options(self) -> dict[str, int]:
        return {"degree": self.degree}

    def bounded(self, model: BSDF) -> bool:
        # |Y_l0| <= 1 keeps only E_0 within [0, 1]; of the others the ends are not known.
        return self.degree == 0 and super().bounded(model)

    def weight(self, mu: Array) -> Array:
        return 2.0 * jnp.pi * zonal_harmonic(self.degree, mu) * mu

    def of(self, albedo: Array) -> Array:
        return 1.0 - albedo

    def _count(self, level: int) -> int:
        # Y_l0(t^2) has the degree 2 l in t: a Gauss-Legendre node more integrates two degrees more.
        return super()._count(level) + self.degree
