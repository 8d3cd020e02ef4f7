"""JAX in 64-bit mode: every module of ecfit takes `jax` and `jnp` from here."""

import jax

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402  (after the switch to 64 bits)

__all__ = ["jax", "jnp"]
