"""Linear least squares for forms without a denominator, in blocks of rows."""

import numpy as np

from ecfit.fitting.problem import Problem
from ecfit.forms.terms import monomials

_BLOCK_ROWS = 16_384


def linear_least_squares(problem: Problem) -> np.ndarray:
    """Chebyshev coefficients of the best polynomial, by normal equations with one refinement.

    In the Chebyshev basis the normal equations lose a few digits at most; solving once more for the residual
    restores them.
    """
    if problem.full:
        return _on_grid(problem)
    count = len(problem.terms.numerator)
    solution = np.zeros(count)
    gram = np.zeros((count, count))
    for sweep in range(2):
        right = np.zeros(count)
        for start in range(0, problem.rows, _BLOCK_ROWS):
            part = slice(start, start + _BLOCK_ROWS)
            powers = [t[i[part]] for t, i in zip(problem.powers, problem.index, strict=True)]
            columns = monomials(problem.terms.numerator, powers)
            weighted = columns * problem.weights[part, None]
            if sweep == 0:
                gram += weighted.T @ columns
            right += weighted.T @ (problem.values[part] - columns @ solution)
        solution = solution + np.linalg.lstsq(gram, right, rcond=None)[0]
    return solution


def _on_grid(problem: Problem) -> np.ndarray:
    """The same on a full grid, where Gram matrix and right side are products over the axes."""
    exponents = problem.terms.numerator
    gram = np.ones((len(exponents), len(exponents)))
    for powers, e in zip(problem.powers, exponents.T, strict=True):
        gram *= (powers.T @ powers)[e[:, None], e[None, :]]

    def moments(values: np.ndarray) -> np.ndarray:
        for powers in problem.powers:
            values = np.tensordot(values, powers, axes=(0, 0))
        return values[tuple(exponents.T)]

    values = problem.values.reshape([len(p) for p in problem.powers])
    solution = np.linalg.lstsq(gram, moments(values), rcond=None)[0]
    rest = values - problem.on_grid(solution, exponents)
    return solution + np.linalg.lstsq(gram, moments(rest), rcond=None)[0]
