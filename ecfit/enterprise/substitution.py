"""The isotropic surface that stands for an anisotropic one in albedos: measured, not the printed product."""

from typing import Any

from ecfit._jax import jax, jnp

Array = jax.Array


def isotropic_equivalent(alpha_u: Any, alpha_v: Any, phi: Any, mu: Any) -> tuple[Array, Array]:
    """(alpha, mu') of isotropic GGX whose E(alpha, mu') is nearly that of widths alpha_u, alpha_v.

    alpha is the root mean square of both widths, and mu' keeps the masking of wo: with the width seen by wo,
    alpha_o^2 = alpha_u^2 cos^2(phi) + alpha_v^2 sin^2(phi), alpha tan(theta') = alpha_o tan(theta). It has no
    fitted number and is exact for equal widths; docs/systems/enterprise-pbr.md has its errors.

    Args: GGX widths in (0, 1], the azimuth of wo from u, its cosine in [0, 1]; arrays broadcast.
    """
    u, v = jnp.asarray(alpha_u) ** 2, jnp.asarray(alpha_v) ** 2
    c2 = jnp.cos(jnp.asarray(phi)) ** 2
    mean = 0.5 * (u + v)
    seen = u * c2 + v * (1.0 - c2)
    mu = jnp.asarray(mu)
    # cos(theta') of tan^2(theta') = tan^2(theta) seen / mean.
    square = mu * mu + (1.0 - mu) * (1.0 + mu) * seen / mean
    return jnp.sqrt(mean), mu / jnp.sqrt(jnp.where(square > 0.0, square, 1.0))
