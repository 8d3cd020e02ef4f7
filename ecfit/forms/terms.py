"""The terms of a quotient P / Q of polynomials: exponents that give a coefficient vector its meaning."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError

# A JAX or a NumPy array: only indexing and arithmetic are used where both come.
Array = Any


def total_degree(variables: int, degree: int) -> np.ndarray:
    """Exponents of all monomials of total degree <= `degree`, shape (terms, variables), int.

    Graded, then lexicographic: 1, x, y, x2, xy, y2, ... (the order of Sforza & Pellacini 2022, eq. 24).
    """
    rows = [
        [combination.count(v) for v in range(variables)]
        for k in range(degree + 1)
        for combination in itertools.combinations_with_replacement(range(variables), k)
    ]
    return np.array(rows, dtype=np.int64)


def monomials(exponents: np.ndarray, powers: Sequence[Array]) -> Array:
    """Products of tabulated powers (or other one-variable bases), shape (..., terms).

    `powers[v]` has shape (..., highest exponent + 1): column k holds the k-th basis function of variable v.
    """
    product = powers[0][..., exponents[:, 0]]
    for v in range(1, exponents.shape[1]):
        product = product * powers[v][..., exponents[:, v]]
    return product


def polynomial(coefficients: Array, exponents: np.ndarray, points: Sequence[Array]) -> Array:
    """sum_k coefficients[k] x^exponents[k] at points given as one array a variable, all of one shape.

    NumPy in, NumPy out; otherwise JAX. Contracts one variable after the other, which costs far less than
    a column for each monomial.
    """
    xp = jnp if any(isinstance(a, jax.Array) for a in (coefficients, *points)) else np
    sizes = exponents.max(axis=0) + 1
    flat = np.ravel_multi_index(tuple(exponents.T), tuple(sizes))
    place = np.zeros((len(exponents), int(np.prod(sizes))))
    place[np.arange(len(exponents)), flat] = 1.0
    shape = points[0].shape
    dense = coefficients @ place  # the dense tensor of coefficients, first variable slowest
    value = _powers(xp, points[0], int(sizes[0])) @ dense.reshape(int(sizes[0]), -1)
    for size, x in zip(sizes[1:], points[1:], strict=True):
        powers = _powers(xp, x, int(size))
        value = (powers[..., None] * value.reshape(*shape, int(size), -1)).sum(axis=-2)
    return value[..., 0]


def _powers(xp: Any, x: Array, count: int) -> Array:
    """1, x, ..., x^(count - 1) in a new last axis."""
    columns = [xp.ones_like(x)]
    for _ in range(count - 1):
        columns.append(columns[-1] * x)
    return xp.stack(columns, axis=-1)


def change_basis(coefficients: np.ndarray, exponents: np.ndarray, tables: Sequence[np.ndarray]) -> np.ndarray:
    """Coefficients of monomials from those of products of other one-variable functions.

    `tables[v]` holds in row k the k-th function of variable v as coefficients of 1, x, x^2, ... The set of
    exponents must be closed downwards, so that it holds all monomials that appear.
    """
    matrix = np.ones((len(exponents), len(exponents)))
    for v, table in enumerate(tables):
        matrix *= table[exponents[:, v][:, None], exponents[:, v][None, :]]
    return coefficients @ matrix


@dataclass(frozen=True, eq=False)
class Terms:
    """Exponents of the numerator and of the denominator; the denominator's constant 1 is implied.

    Attributes:
        numerator: int, shape (p, variables).
        denominator: int, shape (q, variables), without the constant; q = 0 for a polynomial.

    Raises `EcfitError` for exponents that are no whole numbers in 0..100 or repeat, and for a constant in
    the denominator.
    """

    numerator: np.ndarray
    denominator: np.ndarray

    def __post_init__(self) -> None:
        for name in ("numerator", "denominator"):
            array = np.zeros(0, dtype=np.int64)
            try:
                given = np.asarray(getattr(self, name))
                with np.errstate(invalid="ignore"):  # NaN and what does not fit: caught by the comparison
                    array = given.astype(np.int64)
                exact = array.ndim == 2 and bool(np.all(array == given))
            except (TypeError, ValueError, OverflowError):
                exact = False
            if not exact or np.any(array < 0) or np.any(array > 100):
                raise EcfitError(f"{name}: exponents must be a matrix of integers in 0..100")
            if len(np.unique(array, axis=0)) < len(array):
                raise EcfitError(f"{name}: an exponent row repeats")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.numerator.shape[0] == 0 or self.numerator.shape[1] == 0:
            raise EcfitError("numerator: needs at least one term")
        if self.numerator.shape[1] != self.denominator.shape[1]:
            raise EcfitError("numerator and denominator differ in the number of variables")
        if np.any(np.all(self.denominator == 0, axis=1)):
            raise EcfitError("denominator: its constant is 1 by convention and not a term")

    @property
    def variables(self) -> int:
        """Number of variables."""
        return self.numerator.shape[1]

    @property
    def count(self) -> int:
        """Number of free coefficients."""
        return len(self.numerator) + len(self.denominator)

    @property
    def highest(self) -> int:
        """Highest exponent of any variable."""
        return int(max(self.numerator.max(initial=0), self.denominator.max(initial=0)))

    def split(self, coefficients: Array) -> tuple[Array, Array]:
        """Coefficients of the numerator and of the denominator (without its 1)."""
        return coefficients[: len(self.numerator)], coefficients[len(self.numerator) :]

    def parts(self, coefficients: Array, points: Sequence[Array]) -> tuple[Array, Array]:
        """P and Q at points given as one array a variable (they broadcast); NumPy in, NumPy out."""
        xp = jnp if any(isinstance(a, jax.Array) for a in (coefficients, *points)) else np
        arrays = xp.broadcast_arrays(*(xp.asarray(p, dtype=np.float64) for p in points))
        a, b = self.split(xp.asarray(coefficients))
        numerator = polynomial(a, self.numerator, arrays)
        if not len(self.denominator):
            return numerator, xp.ones_like(numerator)
        return numerator, 1.0 + polynomial(b, self.denominator, arrays)

    def converted(self, p: np.ndarray, q: np.ndarray, tables: Sequence[np.ndarray]) -> np.ndarray:
        """Coefficients with the denominator's constant 1 from p and q (q with its constant) in another basis.

        See `change_basis`. Not finite where Q vanishes at the origin of the new coordinates.
        """
        constant = np.zeros((1, self.variables), dtype=np.int64)
        new_p = change_basis(p, self.numerator, tables)
        new_q = change_basis(q, np.concatenate([constant, self.denominator]), tables)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.concatenate([new_p, new_q[1:]]) / new_q[0]

    def on_grid(self, coefficients: np.ndarray, nodes: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """P and Q on the tensor product of nodes (one array a variable), far cheaper than point by point."""
        p, q = self.split(np.asarray(coefficients))
        shape = tuple(len(n) for n in nodes)
        numerator = np.broadcast_to(_dense_on_grid(p, self.numerator, nodes), shape)
        if not len(self.denominator):
            return numerator, np.ones(shape)
        return numerator, 1.0 + _dense_on_grid(q, self.denominator, nodes)


def _dense_on_grid(
    coefficients: np.ndarray, exponents: np.ndarray, nodes: Sequence[np.ndarray]
) -> np.ndarray:
    sizes = exponents.max(axis=0) + 1
    value = np.zeros(sizes)
    value[tuple(exponents.T)] = coefficients
    for size, x in zip(sizes, nodes, strict=True):
        # The first dimension is contracted and comes back as the last: after all, the order is the old one.
        value = np.tensordot(value, np.vander(x, int(size), increasing=True), axes=(0, 1))
    return value
