"""The Enterprise PBR Shading Model 2019x (Dassault Systèmes): its parts and its core as BSDFs."""

from ecfit.enterprise.core import EnterprisePBR as EnterprisePBR
from ecfit.enterprise.dielectric import Opaque as Opaque
from ecfit.enterprise.dielectric import Transparent as Transparent
from ecfit.enterprise.metallic import Metallic as Metallic
from ecfit.enterprise.substitution import isotropic_equivalent as isotropic_equivalent
