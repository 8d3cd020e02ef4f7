"""Spherical harmonics, and what a lobe scatters of an environment given in them."""

from ecfit.harmonics.lobe import lobe_irradiance as lobe_irradiance
from ecfit.harmonics.lobe import multiple_scattering_radiance as multiple_scattering_radiance
from ecfit.harmonics.lobe import rotated_zonal as rotated_zonal
from ecfit.harmonics.real import spherical_harmonics as spherical_harmonics
from ecfit.harmonics.zonal import legendre as legendre
from ecfit.harmonics.zonal import zonal_harmonic as zonal_harmonic
