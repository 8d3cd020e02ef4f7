"""Zonal harmonics: the spherical harmonics that depend on the polar angle only."""

import math

from ecfit._jax import jax, jnp

Array = jax.Array


def legendre(degree: int, x: Array) -> Array:
    """The Legendre polynomial P_l(x), by its three-term recurrence; any l >= 0, shape of x."""
    last, value = jnp.zeros_like(x), jnp.ones_like(x)
    for n in range(1, degree + 1):
        last, value = value, ((2 * n - 1) * x * value - (n - 1) * last) / n
    return value


def zonal_harmonic(degree: int, mu: Array) -> Array:
    """Y_l0 = sqrt((2 l + 1) / (4 pi)) P_l(mu): orthonormal over the sphere; mu in [-1, 1], any shape."""
    return math.sqrt((2 * degree + 1) / (4.0 * math.pi)) * legendre(degree, jnp.asarray(mu))
