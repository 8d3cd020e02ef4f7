"""What an integrator needs of a BSDF: a sequence of ever finer rules for its albedo."""

import abc

import equinox as eqx

from ecfit._jax import jax

Array = jax.Array


class Measure(eqx.Module):
    """A sequence of rules for the directional albedo at one mu, each finer than the one before.

    `refine` compares successive levels to estimate the error. To suit it, a level should have about
    1.5 times (smooth integrands) to 2 times the nodes per dimension of the level before.
    """

    @property
    @abc.abstractmethod
    def levels(self) -> tuple[int, ...]:
        """Number of nodes of each level: what sizes the blocks of entries in memory."""

    @abc.abstractmethod
    def albedo(self, mu: Array, level: int, lobe: str) -> Array:
        """The integral of f |cos theta_i| over wi by the rule of `level`, for the radiance BSDF.

        Args: mu in [0, 1], a scalar; level, static; lobe, "all", "reflection" or "transmission".
        Must be pure JAX: it is run under jit, vmap and grad.
        """
