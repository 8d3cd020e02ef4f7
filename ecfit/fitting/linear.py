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
