"""The formulas of energy compensation: NumPy in, NumPy out; JAX in, JAX out."""

import math
from typing import Any

Array = Any


def turquin_factor(E: Array, F0: Array = 1.0) -> Array:
    """What the single-scattering BSDF is multiplied with: 1 + F0 (1 - E) / E.

    Sforza & Pellacini 2022, eq. 1, 6, 9 and 13, after Turquin 2019. E in (0, 1] is the albedo without
    Fresnel; with F0 = 1 this is 1 / E, which makes the white furnace exact (eq. 7 and 8).
    """
    return 1.0 + F0 * (1.0 - E) / E


def kulla_conty_lobe(E_o: Array, E_i: Array, E_avg: Array, F_ms: Array = 1.0) -> Array:
    """The diffuse multiple-scattering BRDF F_ms (1 - E_o) (1 - E_i) / (pi (1 - E_avg)), in 1/sr.

    Sforza & Pellacini 2022, eq. 4, after Kulla & Conty 2017. E_o and E_i are the albedos of both directions,
    E_avg < 1 their average (eq. 5).
    """
    return F_ms * (1.0 - E_o) * (1.0 - E_i) / (math.pi * (1.0 - E_avg))


def kulla_conty_fresnel(F_avg: Array, E_avg: Array) -> Array:
    """F_ms of all bounces but the first: F_avg^2 E_avg / (1 - F_avg (1 - E_avg)) (Kulla & Conty 2017)."""
    return F_avg * F_avg * E_avg / (1.0 - F_avg * (1.0 - E_avg))
