"""Quantities: what is integrated of a BSDF, and stored in tables."""

from ecfit.quantities.albedo import directional_albedo as directional_albedo
from ecfit.quantities.base import AverageAlbedo as AverageAlbedo
from ecfit.quantities.base import DirectionalAlbedo as DirectionalAlbedo
from ecfit.quantities.base import Quantity as Quantity
from ecfit.quantities.bounces import MultipleBounces as MultipleBounces
from ecfit.quantities.brdf import Brdf as Brdf
from ecfit.quantities.fresnel import FacetFresnel as FacetFresnel
from ecfit.quantities.ltc import LtcScale as LtcScale
from ecfit.quantities.moments import AverageFresnel as AverageFresnel
from ecfit.quantities.moments import F82Moment as F82Moment
from ecfit.quantities.moments import SchlickA as SchlickA
from ecfit.quantities.moments import SchlickB as SchlickB
from ecfit.quantities.points import parameter_map as parameter_map
from ecfit.quantities.registry import quantity as quantity
from ecfit.quantities.zonal import ZonalMoment as ZonalMoment
