"""The least-squares problem of a form and a table, in a well-conditioned basis.

Inside a fit, every variable is mapped to [-1, 1] and the monomials are replaced by products of Chebyshev
polynomials with the same exponents: for a downward-closed set of exponents both span the same functions,
but the normal equations of Chebyshev products are well conditioned. The result is converted to plain
monomials of the stated coordinates.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ecfit.forms import Terms
from ecfit.forms.terms import monomials
from ecfit.tables import Table


def chebyshev_powers(x: np.ndarray, low: float, high: float, highest: int) -> np.ndarray:
    """T_0 .. T_highest of x mapped from [low, high] to [-1, 1], shape (len(x), highest + 1)."""
    return np.polynomial.chebyshev.chebvander((2.0 * x - low - high) / (high - low), highest)


def _to_monomials(highest: int, low: float, high: float) -> np.ndarray:
    """Row k: coefficients of 1, x, x^2, ... of T_k mapped from [low, high]."""
    scaled = np.polynomial.Polynomial([-(low + high) / (high - low), 2.0 / (high - low)])
    matrix = np.zeros((highest + 1, highest + 1))
    for k in range(highest + 1):
        plain = np.polynomial.chebyshev.cheb2poly(np.eye(highest + 1)[k])
        row = np.polynomial.Polynomial(plain)(scaled).coef
        matrix[k, : len(row)] = row
    return matrix


def from_unit_monomials(highest: int) -> np.ndarray:
    """Row k: Chebyshev coefficients of t^k, t in [0, 1] being the variable mapped from its range."""
    matrix = np.zeros((highest + 1, highest + 1))
    for k in range(highest + 1):
        row = np.polynomial.chebyshev.poly2cheb((np.polynomial.Polynomial([0.5, 0.5]) ** k).coef)
        matrix[k, : len(row)] = row
    return matrix


def thin(count: int, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """A quadrature rule on some of `count` equidistant indices that stands for the sum over all of them.

    The chosen indices cluster towards the ends like Gauss nodes; the weights reproduce the sums of all
    polynomials of the index up to half the number of nodes, so smooth residuals are summed to rounding.
    Returns (indices, weights), weights positive.
    """
    position = 0.5 * (1.0 - np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes))
    chosen = np.unique(np.r_[0, np.round(position * (count - 1)).astype(int), count - 1])
    nearest = np.abs(np.arange(count)[:, None] - chosen).argmin(axis=1)
    weights = np.bincount(nearest, minlength=len(chosen)).astype(float)
    x = 2.0 * np.arange(count) / (count - 1) - 1.0
    for degree in range(len(chosen) // 2, 0, -4):
        moments = np.polynomial.chebyshev.chebvander(x, degree)
        some = moments[chosen]
        # The smallest relative change of the weights that matches the sums of all moments.
        change = np.linalg.lstsq(
            (some * weights[:, None]).T, moments.sum(axis=0) - some.T @ weights, rcond=None
        )
        matched = weights * (1.0 + change[0])
        if matched.min() > 0.0:
            return chosen, matched
    return chosen, weights


@dataclass(frozen=True, eq=False)
class Problem:
    """Rows of a table (all, or a weighted choice of them) and the Chebyshev values at their nodes.

    Attributes:
        terms: exponents.
        domain: (low, high) a variable.
        powers: per variable, Chebyshev values at the axis nodes, shape (nodes, highest + 1).
        index: per variable, the node of each row, int32, shape (rows,).
        values: target of each row, shape (rows,).
        weights: weight of each row in the sum of squares, shape (rows,).
        full: whether the rows are all nodes of the grid in order, with equal weights.
        watched: places, one row each in the variables, where the denominator is guarded too.
    """

    terms: Terms
    domain: tuple[tuple[float, float], ...]
    powers: tuple[np.ndarray, ...]
    index: tuple[np.ndarray, ...]
    values: np.ndarray
    weights: np.ndarray
    full: bool = False
    watched: tuple[tuple[float, ...], ...] = ()

    @classmethod
    def of_table(cls, table: Table, terms: Terms) -> "Problem":
        """All finite entries, weighted equally; coordinates as a fit sees them."""
        axes, domain = table.axes, table.grid.domain
        powers = tuple(
            chebyshev_powers(a.nominal, *d, terms.highest) for a, d in zip(axes, domain, strict=True)
        )
        flat = np.flatnonzero(table.usable.ravel())
        index = tuple(i.astype(np.int32) for i in np.unravel_index(flat, table.grid.shape))
        values = table.values.ravel()[flat]
        return cls(terms, domain, powers, index, values, np.ones(flat.size), flat.size == table.values.size)

    @property
    def rows(self) -> int:
        return self.values.size

    def on_grid(self, coefficients: np.ndarray, exponents: np.ndarray) -> np.ndarray:
        """A combination of basis products on the whole grid of a `full` problem, the grid's shape."""
        dense = np.zeros([p.shape[1] for p in self.powers])
        dense[tuple(exponents.T)] = coefficients
        for powers in self.powers:
            # The first dimension is contracted and comes back as the last.
            dense = np.tensordot(dense, powers, axes=(0, 1))
        return dense

    def thinned(self, nodes: int) -> "Problem":
        """At most about `nodes` nodes an axis, weighted to stand for all of them (see `thin`)."""
        weight, keep = np.ones(self.rows), np.ones(self.rows, dtype=bool)
        for powers, column in zip(self.powers, self.index, strict=True):
            if len(powers) > nodes:
                chosen, w = thin(len(powers), nodes)
                full = np.zeros(len(powers))
                full[chosen] = w
                keep &= full[column] > 0.0
                weight = weight * full[column]
        return Problem(
            self.terms,
            self.domain,
            self.powers,
            tuple(c[keep] for c in self.index),
            self.values[keep],
            weight[keep],
            watched=self.watched,
        )

    def watching(self, place: tuple[float, ...]) -> "Problem":
        """The same problem with one more place where the denominator is guarded."""
        return replace(self, watched=(*self.watched, place))

    @cached_property
    def columns(self) -> tuple[np.ndarray, np.ndarray]:
        """Basis values of numerator and denominator (with its constant first)."""
        powers = [p[i] for p, i in zip(self.powers, self.index, strict=True)]
        numerator = monomials(self.terms.numerator, powers)  # type: ignore[arg-type]
        denominator = np.ones((self.rows, 1))
        if len(self.terms.denominator):
            rest = monomials(self.terms.denominator, powers)  # type: ignore[arg-type]
            denominator = np.concatenate([denominator, rest], axis=1)
        return np.asarray(numerator), np.asarray(denominator)

    @cached_property
    def guards(self) -> np.ndarray:
        """Denominator basis on a grid of its own, ends included, and at the watched places."""
        variables = self.terms.variables
        count = 41 if variables <= 2 else 15
        axis = -np.cos(np.pi * np.arange(count) / (count - 1))
        powers = np.polynomial.chebyshev.chebvander(axis, self.terms.highest)
        mesh = np.meshgrid(*[np.arange(count)] * variables, indexing="ij")
        rows = [powers[m.ravel()] for m in mesh]
        if self.watched:
            places = np.array(self.watched).T
            extra = [
                chebyshev_powers(x, *d, self.terms.highest) for x, d in zip(places, self.domain, strict=True)
            ]
            rows = [np.concatenate(pair) for pair in zip(rows, extra, strict=True)]
        ones = np.ones((rows[0].shape[0], 1))
        if not len(self.terms.denominator):
            return ones
        rest = monomials(self.terms.denominator, rows)  # type: ignore[arg-type]
        return np.concatenate([ones, np.asarray(rest)], axis=1)

    def plain_coefficients(self, numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
        """Coefficients of plain monomials with the denominator's constant 1, from Chebyshev ones.

        `denominator` includes the constant. Not finite where Q vanishes at the origin of the coordinates.
        """
        tables = [_to_monomials(self.terms.highest, *d) for d in self.domain]
        return self.terms.converted(numerator, denominator, tables)


def blocks(arrays: Sequence[np.ndarray], rows: int) -> list[np.ndarray]:
    """Arrays reshaped to (blocks, rows, ...), the last block padded with zeros (zero weight: no effect)."""
    count = arrays[0].shape[0]
    padding = -(-count // rows) * rows - count
    padded = [np.pad(a, [(0, padding)] + [(0, 0)] * (a.ndim - 1)) for a in arrays]
    return [a.reshape(-1, rows, *a.shape[1:]) for a in padded]
