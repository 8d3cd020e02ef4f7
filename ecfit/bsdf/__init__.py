"""BSDF models: the one method they need, their registry, and those that ecfit ships."""

from ecfit.bsdf.anisotropic import AnisotropicConductor as AnisotropicConductor
from ecfit.bsdf.base import BSDF as BSDF
from ecfit.bsdf.base import option as option
from ecfit.bsdf.base import parameter as parameter
from ecfit.bsdf.burley import Burley as Burley
from ecfit.bsdf.conductor import Conductor as Conductor
from ecfit.bsdf.dielectric import Dielectric as Dielectric
from ecfit.bsdf.dielectric import ThinDielectric as ThinDielectric
from ecfit.bsdf.lambertian import Lambertian as Lambertian
from ecfit.bsdf.microfacet_diffuse import MicrofacetDiffuse as MicrofacetDiffuse
from ecfit.bsdf.oren_nayar import EnergyPreservingOrenNayar as EnergyPreservingOrenNayar
from ecfit.bsdf.oren_nayar import FujiiOrenNayar as FujiiOrenNayar
from ecfit.bsdf.oren_nayar import QualitativeOrenNayar as QualitativeOrenNayar
from ecfit.bsdf.registry import as_model as as_model
from ecfit.bsdf.registry import model as model
from ecfit.bsdf.registry import models as models
from ecfit.bsdf.registry import register as register
from ecfit.bsdf.sheen import AshikhminSheen as AshikhminSheen
from ecfit.bsdf.sheen import ImageworksSheen as ImageworksSheen
