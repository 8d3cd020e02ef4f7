"""The minimum of a polynomial over a box, by Bernstein coefficients and subdivision.

A polynomial on a box lies within the range of its Bernstein coefficients there, and the corner
coefficients are its values: that bounds the minimum from both sides (Garloff 1986). The bounds are exact up
to rounding (about 1e-14 of the largest coefficient), not outward rounded.
"""

import heapq
import itertools
from collections.abc import Sequence
from functools import cache
from math import comb

import numpy as np

from ecfit.expressions.bounds import Minimum as Minimum
from ecfit.forms.terms import Terms


@cache
def _halves(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """de Casteljau at the midpoint: matrices to the coefficients of the left and of the right half."""
    left = np.array([[comb(i, j) / 2.0**i for j in range(degree + 1)] for i in range(degree + 1)])
    return left, left[::-1, ::-1].copy()


def _to_bernstein(degree: int, low: float, high: float) -> np.ndarray:
    """Matrix from coefficients of 1, x, ..., x^degree to Bernstein coefficients on [low, high]."""
    width = high - low
    # x = low + width u: coefficients in u, then in Bernstein polynomials of u.
    shift = np.array(
        [
            [comb(k, m) * low ** (k - m) * width**m if m <= k else 0.0 for k in range(degree + 1)]
            for m in range(degree + 1)
        ]
    )
    raise_ = np.array(
        [
            [comb(j, m) / comb(degree, m) if m <= j else 0.0 for m in range(degree + 1)]
            for j in range(degree + 1)
        ]
    )
    return raise_ @ shift


def _apply(matrix: np.ndarray, tensor: np.ndarray, axis: int) -> np.ndarray:
    return np.moveaxis(np.tensordot(matrix, tensor, axes=(1, axis)), 0, axis)


def minimum(
    coefficients: np.ndarray,
    exponents: np.ndarray,
    box: Sequence[tuple[float, float]],
    tolerance: float = 1e-9,
    splits: int = 4000,
) -> Minimum:
    """The minimum over `box` of the polynomial sum_k coefficients[k] x^exponents[k].

    Args:
        coefficients: shape (terms,); exponents: int, shape (terms, variables).
        box: (low, high) of each variable.
        tolerance: stop when the bounds are within this of each other, relative to max(1, |value|).
        splits: stop after this many subdivisions; the bounds then remain apart.
    """
    n = exponents.shape[1]
    degrees = exponents.max(axis=0)
    tensor = np.zeros(degrees + 1)
    np.add.at(tensor, tuple(exponents.T), coefficients)
    for v in range(n):
        tensor = _apply(_to_bernstein(int(degrees[v]), *box[v]), tensor, v)
    lows, widths = np.array([b[0] for b in box]), np.array([b[1] - b[0] for b in box])
    corners = list(itertools.product(*((0, -1),) * n))

    best, place = np.inf, tuple(lows)
    serial = itertools.count()  # breaks ties in the heap without comparing arrays
    heap: list = []

    def push(tensor: np.ndarray, low: np.ndarray, width: np.ndarray) -> None:
        nonlocal best, place
        for corner in corners:
            value = float(tensor[corner])
            if value < best:
                best = value
                place = tuple(
                    float(a + w) if c else float(a) for a, w, c in zip(low, width, corner, strict=True)
                )
        heapq.heappush(heap, (float(tensor.min()), next(serial), tensor, low, width))

    push(tensor, lows, widths)
    for _ in range(splits):
        bound = heap[0][0]
        if best - bound <= tolerance * max(1.0, abs(best)):
            break
        _, _, tensor, low, width = heapq.heappop(heap)
        # Split where the coefficients vary most.
        spans = [np.abs(np.diff(tensor, axis=v)).max(initial=0.0) * degrees[v] for v in range(n)]
        v = int(np.argmax(spans))
        half = width.copy()
        half[v] *= 0.5
        right = low.copy()
        right[v] += half[v]
        for matrix, origin in zip(_halves(int(degrees[v])), (low, right), strict=True):
            push(_apply(matrix, tensor, v), origin, half)
    return Minimum(best, place, min(heap[0][0], best))


def smallest_denominator(
    terms: Terms, coefficients: np.ndarray, box: Sequence[tuple[float, float]]
) -> Minimum:
    """The minimum over a box of a quotient's denominator Q, in units of its constant 1.

    Where Q is negative at the centre of the box it is -Q that is minimised (Q is 1 at the origin, which may
    lie outside the box): the bound is positive exactly where Q has no zero in the box, up to rounding.
    """
    constant = np.zeros((1, terms.variables), dtype=np.int64)
    exponents = np.concatenate([constant, terms.denominator])
    q = np.concatenate([[1.0], terms.split(coefficients)[1]])
    centre = np.array([0.5 * (low + high) for low, high in box])
    sign = 1.0 if q @ np.prod(centre**exponents, axis=1) >= 0.0 else -1.0
    return minimum(sign * q, exponents, box)
