"""Quadrature: ever finer rules for the albedo integral, and their refinement with error estimates."""

from ecfit.quadrature.anisotropic import AnisotropicReflection as AnisotropicReflection
from ecfit.quadrature.cosine import CosineRule as CosineRule
from ecfit.quadrature.cosine import cosine_count as cosine_count
from ecfit.quadrature.facets import FacetPairs as FacetPairs
from ecfit.quadrature.half_vector import HalfVectorReflection as HalfVectorReflection
from ecfit.quadrature.half_vector import ThinInterface as ThinInterface
from ecfit.quadrature.hemisphere import Hemisphere as Hemisphere
from ecfit.quadrature.interface import Interface as Interface
from ecfit.quadrature.measure import Measure as Measure
from ecfit.quadrature.paired import PairedHemisphere as PairedHemisphere
from ecfit.quadrature.refine import FINE as FINE
from ecfit.quadrature.refine import STATUS as STATUS
from ecfit.quadrature.refine import Refined as Refined
from ecfit.quadrature.refine import Status as Status
from ecfit.quadrature.refine import refine as refine
from ecfit.quadrature.rules import Estimate as Estimate
from ecfit.quadrature.rules import gauss_legendre as gauss_legendre
from ecfit.quadrature.total import Total as Total
