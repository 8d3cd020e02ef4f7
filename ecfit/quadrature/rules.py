"""Gauss-Legendre rules on panels, that report how fast the integrand's expansion falls off.

The error estimate does not compare two rules (their difference vanishes by accident where the error
changes its sign, about once in a hundred entries). It expands the integrand on each panel in Legendre
polynomials, which the nodes give for free, and continues the decay seen between two bands of the highest
coefficients: an n-point rule is exact up to degree 2 n - 1, so its error is that of coefficients beyond.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from ecfit._jax import jax, jnp

Array = jax.Array

# Continuing the decay by one band (a quarter of the degrees) where the rule's exactness would allow four
# leaves a margin of 5 to 100 for analytic integrands. The ratio is not trusted below this: rounding and
# integrands that are nearly even or odd make single coefficients small.
_BEST_RATIO = 0.05


class Estimate(NamedTuple):
    """A value and an absolute error estimate, arrays of one shape."""

    value: Array
    error: Array


class Rule(NamedTuple):
    """Gauss-Legendre on panels of [0, 1]: nodes and panel widths of shape (panels x order,)."""

    nodes: np.ndarray
    widths: np.ndarray
    order: int

    @property
    def weights(self) -> np.ndarray:
        """The weight of each node, panel width included."""
        return self.widths * np.tile(gauss_legendre(self.order)[1], self.nodes.size // self.order)


@cache
def gauss_legendre(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1]: exact for polynomials of degree 2 count - 1."""
    x, w = np.polynomial.legendre.leggauss(count)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    x.setflags(write=False)
    w.setflags(write=False)
    return x, w


@cache
def graded(depth: int, count: int) -> Rule:
    """`count` nodes on each of the panels [0, 2^-depth], ..., [1/4, 1/2], [1/2, 1].

    The dyadic panels resolve a peak at 0 whose width is about 2^-depth or more; depth 0 is one panel.
    """
    edges = np.concatenate([[0.0], 0.5 ** np.arange(depth, -1, -1)])
    x, _ = gauss_legendre(count)
    width = np.repeat(np.diff(edges), count)
    return Rule(np.repeat(edges[:-1], count) + width * np.tile(x, depth + 1), width, count)


@cache
def _functionals(count: int) -> tuple[np.ndarray, int]:
    """Columns that turn the values at `count` nodes into [integral, high band, lower band]."""
    x, w = gauss_legendre(count)
    degrees = np.arange(count)
    coefficients = w[:, None] * np.polynomial.legendre.legvander(2.0 * x - 1.0, count - 1)
    coefficients = coefficients * np.sqrt(2.0 * degrees + 1.0)
    step = max(2, count // 4)  # the band's distance; of each band at most the 4 highest degrees
    kept = min(4, step)
    high = coefficients[:, count - kept :]
    low = coefficients[:, count - step - kept : count - step]
    return np.concatenate([w[:, None], high, low], axis=1), kept


def _bands(values: Array, count: int) -> tuple[Array, Array, Array]:
    """Integral, and sizes of the two bands, over the last axis of panels x count values."""
    columns, kept = _functionals(count)
    m = values.reshape(*values.shape[:-1], -1, count) @ columns
    a = jnp.abs(m[..., 1:])
    high, low = jnp.max(a[..., :kept], axis=-1), jnp.max(a[..., kept:], axis=-1)
    return jnp.sum(m[..., 0], axis=-1), jnp.sum(high, axis=-1), jnp.sum(low, axis=-1)


def _tail(high: Array, low: Array) -> Array:
    ratio = high / jnp.where(low > 0.0, low, 1.0)
    return high * jnp.clip(jnp.where(low > 0.0, ratio, 1.0), _BEST_RATIO, 1.0)


def integrate_line(values: Array, rule: Rule) -> Estimate:
    """Integral over [0, 1] with an error estimate; `values` (nodes,) include the panel widths."""
    value, high, low = _bands(values, rule.order)
    return Estimate(value, jax.lax.stop_gradient(_tail(high, low)))


def integrate(values: Array, outer: Rule, inner: Rule) -> Estimate:
    """Integral over the unit square with an error estimate.

    `values` has shape (outer nodes, inner nodes): the integrand times the panel widths of both rules, for
    one or more copies of each rule side by side.
    """
    over_inner, high, low = _bands(values, inner.order)
    line = integrate_line(over_inner, outer)
    panels = over_inner.shape[0] // outer.order
    w = jnp.asarray(np.tile(gauss_legendre(outer.order)[1], panels))
    return Estimate(line.value, line.error + jax.lax.stop_gradient(_tail(w @ high, w @ low)))
