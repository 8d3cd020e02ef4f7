"""What a lobe that is symmetric about the normal receives of an environment given in nine harmonics."""

import math
from typing import Any

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError
from ecfit.harmonics.real import DEGREES, spherical_harmonics

Array = jax.Array

_TURN = np.array([math.sqrt(4.0 * math.pi / (2 * degree + 1)) for degree in DEGREES])


def rotated_zonal(moments: Any, normal: Any) -> Array:
    """The nine coefficients of a lobe with zonal moments (E_0, E_1, E_2) about z, turned to a normal.

    E_lm(n) = sqrt(4 pi / (2 l + 1)) E_l Y_lm(n) (Sloan 2008; MSBRDF blog, Mayaux 2018 part 2).

    Args:
        moments: shape (..., 3).
        normal: unit vectors, shape (..., 3).

    Returns shape (..., 9); leading dimensions broadcast. Raises `EcfitError` for other shapes.
    """
    moments, normal = _triples("moments", moments), _triples("normal", normal)
    return jnp.asarray(_TURN) * moments[..., np.array(DEGREES)] * spherical_harmonics(normal)


def lobe_irradiance(environment: Any, moments: Any, normal: Any) -> Array:
    """The integral of L(wi) (1 - E(wi.n)) wi.n over the hemisphere of n, for L given in nine harmonics.

    Exact where L has no degree above 2 and the moments are exact: harmonics are orthogonal, so that the
    moments of degree 3 and more of the lobe meet nothing.

    Args:
        environment: coefficients L_lm of the radiance, shape (..., 9).
        moments: E_0, E_1, E_2 of the quantity "zonal-moment", shape (..., 3).
        normal: unit vectors in the environment's frame, shape (..., 3).

    Returns the leading shape. Raises `EcfitError` for other shapes.
    """
    environment = jnp.asarray(environment, dtype=jnp.float64)
    if environment.ndim == 0 or environment.shape[-1] != 9:
        raise EcfitError(f"environment must have shape (..., 9), got {environment.shape}")
    return jnp.sum(environment * rotated_zonal(moments, normal), axis=-1)


def multiple_scattering_radiance(
    environment: Any, moments: Any, normal: Any, E_o: Any, E_avg: Any, F_ms: Any = 1.0
) -> Array:
    """Radiance that the Kulla-Conty lobe reflects of an environment of nine harmonics.

    F_ms (1 - E_o) / (pi (1 - E_avg)) x `lobe_irradiance`: with E_avg in [0, 1], so that a white surface in
    a uniform environment of radiance 1 adds exactly 1 - E_o. The MSBRDF blog writes pi - E_avg: there E_avg
    is without the 1 / pi, pi times ours (docs/systems/msbrdf.md).

    Args:
        environment, moments, normal: see `lobe_irradiance`.
        E_o: directional albedo at the view direction; E_avg: average albedo, less than 1.
        F_ms: the lobe's share per channel (`ecfit.compensation.kulla_conty_fresnel`).
    """
    return F_ms * (1.0 - E_o) / (math.pi * (1.0 - E_avg)) * lobe_irradiance(environment, moments, normal)


def _triples(name: str, value: Any) -> Array:
    value = jnp.asarray(value, dtype=jnp.float64)
    if value.ndim == 0 or value.shape[-1] != 3:
        raise EcfitError(f"{name} must have shape (..., 3), got {value.shape}")
    return value
