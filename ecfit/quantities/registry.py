"""Quantities by name."""

from ecfit.errors import EcfitError, unknown
from ecfit.quantities.base import AverageAlbedo, DirectionalAlbedo, Quantity
from ecfit.quantities.bounces import MultipleBounces
from ecfit.quantities.brdf import Brdf
from ecfit.quantities.fresnel import FacetFresnel
from ecfit.quantities.ltc import LtcScale
from ecfit.quantities.moments import AverageFresnel, F82Moment, SchlickA, SchlickB
from ecfit.quantities.zonal import ZonalMoment

_QUANTITIES: dict[str, type[Quantity]] = {
    "directional-albedo": DirectionalAlbedo,
    "average-albedo": AverageAlbedo,
    "schlick-a": SchlickA,
    "schlick-b": SchlickB,
    "f82-moment": F82Moment,
    "average-fresnel": AverageFresnel,
    "zonal-moment": ZonalMoment,
    "multiple-bounces": MultipleBounces,
    "ltc-scale": LtcScale,
    "fresnel": FacetFresnel,
    "brdf": Brdf,
}


def quantity(name: str, lobe: str = "all", transport: str = "energy", **options: int) -> Quantity:
    """The quantity of that name; `options` are its settings, such as `exponent`.

    Raises `EcfitError` for an unknown name, lobe, transport or setting.
    """
    if name not in _QUANTITIES:
        raise unknown("quantity", name, _QUANTITIES)
    try:
        return _QUANTITIES[name](lobe, transport, **options)
    except TypeError:
        raise EcfitError(f"quantity '{name}' does not take {', '.join(options)}") from None
