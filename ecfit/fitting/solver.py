"""Optimistix Levenberg-Marquardt on a `Problem`: steps into Q <= 0 are refused, rows come in blocks."""

from functools import partial
from typing import NamedTuple

import numpy as np
import optimistix as optx

from ecfit._jax import jax, jnp
from ecfit.fitting.bounded import BoundedLevenbergMarquardt
from ecfit.fitting.linear import linear_least_squares
from ecfit.fitting.problem import Problem, blocks
from ecfit.forms.terms import monomials

Array = jax.Array

# Q has constant Chebyshev coefficient 1, so its mean is about 1: below this it counts as a pole.
_LEAST_Q = 1e-6
# Residual reported for a refused step: far above any true one (|E| is of order 1), far from overflow.
_REFUSED = 1e6
# Rows a block: basis values of 132 columns then take 8 MB.
_BLOCK_ROWS = 8192


class Solution(NamedTuple):
    """Chebyshev coefficients (q with its constant), the sum of squares, and how it ended."""

    p: np.ndarray
    q: np.ndarray
    sum_of_squares: float
    converged: bool
    steps: int


def _split(problem_terms: tuple[int, int], y: Array) -> tuple[Array, Array]:
    p, q = y[: problem_terms[0]], y[problem_terms[0] :]
    return p, jnp.concatenate([jnp.ones(1), q])


@partial(jax.jit, static_argnames=("sizes", "guarded"))
def _solve(y, scale, columns_p, columns_q, f, w, guards, barrier, rtol, max_steps, *, sizes, guarded):
    """Levenberg-Marquardt without ever holding all rows' Jacobian; arrays come in blocks of rows.

    It sees the residual r and Jacobian J only through r'r, J'r and J'J. Those are summed over blocks of
    rows, and their symmetric square root S (S'S = [J r]'[J r]) is handed to it as a small problem:
    residual S[:, -1], Jacobian S[:, :-1].
    """

    def rows(y, row):
        columns_p, columns_q, f, w = row
        p, q = _split(sizes, y)
        denominator = columns_q @ q
        prediction = columns_p @ p / denominator
        scaled = w / denominator
        jacobian = jnp.concatenate(
            [columns_p * scaled[:, None], -columns_q[:, 1:] * (scaled * prediction)[:, None]], axis=1
        )
        return jnp.concatenate([jacobian * scale, (w * (prediction - f))[:, None]], axis=1), denominator

    def barrier_rows(y):
        _, q = _split(sizes, y)
        denominator = guards @ q
        value = barrier / denominator
        jacobian = jnp.concatenate(
            [jnp.zeros((guards.shape[0], sizes[0])), -guards[:, 1:] * (value / denominator)[:, None]], axis=1
        )
        return jnp.concatenate([jacobian * scale, value[:, None]], axis=1), denominator

    def root(z):
        y = z * scale

        def add(carry, row):
            gram, least = carry
            columns, denominator = rows(y, row)
            return (gram + columns.T @ columns, jnp.minimum(least, jnp.min(denominator))), None

        columns, denominator = barrier_rows(y)
        start = columns.T @ columns, jnp.min(denominator)
        (gram, least), _ = jax.lax.scan(add, start, (columns_p, columns_q, f, w))
        values, vectors = jnp.linalg.eigh(gram)
        s = jnp.sqrt(jnp.maximum(values, 0.0))[:, None] * vectors.T
        return jnp.where((least > _LEAST_Q) | (not guarded), s[:, -1], _REFUSED), s[:, :-1]

    @jax.custom_jvp
    def residual(z):
        return root(z)[0]

    @residual.defjvp
    def _(primals, tangents):
        value, jacobian = root(primals[0])
        return value, jacobian @ tangents[0]

    solver = BoundedLevenbergMarquardt(rtol, 1e-14, max_steps)
    solution = optx.least_squares(lambda z, _: residual(z), solver, y / scale, max_steps=None, throw=False)
    converged = solution.result == optx.RESULTS.successful
    return solution.value, converged, solution.stats["num_steps"]


def solve(
    problem: Problem,
    start: tuple[np.ndarray, np.ndarray],
    *,
    barrier: float = 0.0,
    rtol: float,
    max_steps: int,
    guarded: bool = True,
) -> Solution:
    """Minimise the weighted mean square residual from a start (p, q), plus barrier^2 x mean of 1 / Q^2.

    Steps into Q <= 0, on rows and guards, are refused; not so if `guarded` is false.
    """
    p, q = start
    sizes = (len(p), len(q) - 1)
    root_w = np.sqrt(problem.weights / problem.weights.sum())
    arrays = [*problem.columns, problem.values, root_w]
    columns_p, columns_q, f, w = blocks(arrays, min(_BLOCK_ROWS, problem.rows))
    # Padding has no weight; its denominator must not vanish.
    columns_q[-1, problem.rows - (len(columns_q) - 1) * columns_q.shape[1] :, 0] = 1.0
    scale = _column_scale(problem, p, q)
    z, converged, steps = _solve(
        np.concatenate([p, q[1:]]),
        scale,
        columns_p,
        columns_q,
        f,
        w,
        problem.guards,
        barrier / np.sqrt(len(problem.guards)),
        rtol,
        max_steps,
        sizes=sizes,
        guarded=guarded,
    )
    y = np.asarray(z) * scale
    p, q = y[: sizes[0]], np.concatenate([[1.0], y[sizes[0] :]])
    return Solution(p, q, mean_square(problem, p, q), bool(converged), int(steps))


def linear_solution(problem: Problem) -> Solution:
    """The solution of a problem without a denominator."""
    p, q = linear_least_squares(problem), np.ones(1)
    return Solution(p, q, mean_square(problem, p, q), True, 1)


def _column_scale(problem: Problem, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """1 / norm of the Jacobian's columns at the start: the solver's damping knows no scale of its own."""
    thin = problem if problem.rows <= 50_000 else problem.thinned(32)
    columns_p, columns_q = thin.columns
    denominator = columns_q @ q
    root_w = np.sqrt(thin.weights / thin.weights.sum()) / denominator
    prediction = columns_p @ p / denominator
    norms = np.concatenate(
        [
            np.linalg.norm(columns_p * root_w[:, None], axis=0),
            np.linalg.norm(columns_q[:, 1:] * (root_w * prediction)[:, None], axis=0),
        ]
    )
    return 1.0 / np.maximum(norms, 1e-12 * norms.max())


def mean_square(problem: Problem, p: np.ndarray, q: np.ndarray) -> float:
    """Weighted mean square residual."""
    if problem.full:
        numerator = problem.on_grid(p, problem.terms.numerator)
        denominator = q[0] + problem.on_grid(q[1:], problem.terms.denominator)
        return float(np.mean(np.square((numerator / denominator).ravel() - problem.values)))
    total = 0.0
    for start in range(0, problem.rows, _BLOCK_ROWS):
        part = slice(start, start + _BLOCK_ROWS)
        powers = [t[i[part]] for t, i in zip(problem.powers, problem.index, strict=True)]
        numerator = monomials(problem.terms.numerator, powers) @ p
        denominator = q[0] + monomials(problem.terms.denominator, powers) @ q[1:]
        total += float(problem.weights[part] @ np.square(numerator / denominator - problem.values[part]))
    return total / float(problem.weights.sum())
