"""What an integrator needs of a BSDF: a sequence of ever finer rules for its albedo."""

import abc
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax
from ecfit.quadrature.rules import Estimate

Array = jax.Array


class Measure(eqx.Module):
    """A sequence of rules for the directional albedo at one mu, each finer than the one before.

    Class attributes:
        default_level: the level of `ecfit.directional_albedo`, which does not refine.
        confirm: whether a level's estimate counts only once the next level agrees with it. Needed where
            the integrand may hide a peak between the nodes.
    """

    default_level: ClassVar[int] = 0
    confirm: ClassVar[bool] = True

    @property
    @abc.abstractmethod
    def levels(self) -> tuple[int, ...]:
        """Number of nodes of each level: what sizes the blocks of entries in memory."""

    @abc.abstractmethod
    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        """The integral of f |cos theta_i| over wi by the rule of `level`, for the radiance BSDF.

        Args: mu in [0, 1], a scalar; level, static; lobe, "all", "reflection" or "transmission".
        Must be pure JAX: it is run under jit, vmap and grad.
        """
