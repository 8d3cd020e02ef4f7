"""The clamped cosine under M = diag(a, a, 1): the transform that keeps a lobe symmetric about the normal."""

import math
from typing import Any

from ecfit._jax import jax, jnp

Array = jax.Array


def stretched_cosine(mu: Any, scale: Any) -> Array:
    """D(mu) = mu a^2 / (pi (1 - mu^2 + a^2 mu^2)^2), per steradian (Heitz et al. 2016, eq. 1).

    It integrates to 1 over the hemisphere; a = 1 is the clamped cosine over pi, a > 1 leans towards grazing.

    Args:
        mu: cosine with the normal, any shape; 0 below the horizon.
        scale: a > 0; broadcasts.
    """
    mu = jnp.maximum(jnp.asarray(mu, dtype=jnp.float64), 0.0)
    square = jnp.asarray(scale, dtype=jnp.float64) ** 2
    length = (1.0 - mu) * (1.0 + mu) + square * mu * mu
    return mu * square / (math.pi * length * length)
