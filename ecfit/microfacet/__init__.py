"""The microfacet kit: distributions of normals, masking-shadowing, Fresnel factors."""

from ecfit.microfacet.fresnel import ConductorFresnel as ConductorFresnel
from ecfit.microfacet.fresnel import DielectricFresnel as DielectricFresnel
from ecfit.microfacet.fresnel import F82TintFresnel as F82TintFresnel
from ecfit.microfacet.fresnel import Fresnel as Fresnel
from ecfit.microfacet.fresnel import SchlickDielectricFresnel as SchlickDielectricFresnel
from ecfit.microfacet.fresnel import SchlickFresnel as SchlickFresnel
from ecfit.microfacet.fresnel import UnitFresnel as UnitFresnel
from ecfit.microfacet.ndf import GGX as GGX
from ecfit.microfacet.ndf import NDF as NDF
from ecfit.microfacet.ndf import NDFS as NDFS
from ecfit.microfacet.ndf import Beckmann as Beckmann
from ecfit.microfacet.smith import G1 as G1
from ecfit.microfacet.smith import G2 as G2
from ecfit.microfacet.smith import INTERFACE_MASKINGS as INTERFACE_MASKINGS
from ecfit.microfacet.smith import MASKINGS as MASKINGS
from ecfit.microfacet.smith import Lambda as Lambda
from ecfit.microfacet.smith import masking_shadowing as masking_shadowing
