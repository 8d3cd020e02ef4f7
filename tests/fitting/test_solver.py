"""Levenberg-Marquardt: it reaches a minimum, keeps Q > 0, and says when it did not converge."""

import numpy as np
import pytest

from ecfit.fitting.problem import Problem
from ecfit.fitting.solver import linear_solution, mean_square, solve
from ecfit.fitting.start import polynomial_start
from ecfit.forms import Polynomial, Rational


@pytest.fixture(scope="module")
def problem(make_table, unit_axis) -> Problem:
    """A rational fit of degree 2 to a function that is none."""
    table = make_table(
        lambda x, y: np.sqrt(0.02 + x) * np.exp(-3.0 * y), unit_axis("r", 14), unit_axis("mu", 13)
    )
    return Problem.of_table(table, Rational(2).terms(2))


@pytest.fixture(scope="module")
def start(problem):
    return polynomial_start(problem)


@pytest.fixture(scope="module")
def solution(problem, start):
    return solve(problem, start, rtol=1e-10, max_steps=300)


def residual(problem: Problem, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    columns_p, columns_q = problem.columns
    return columns_p @ p / (columns_q @ q) - problem.values


def test_the_stated_sum_of_squares_is_the_mean_square_residual(problem, solution):
    found = residual(problem, solution.p, solution.q)
    assert solution.sum_of_squares == pytest.approx(np.mean(found**2), rel=1e-12)
    assert mean_square(problem, solution.p, solution.q) == solution.sum_of_squares


def test_it_descends_to_a_stationary_point(problem, start, solution):
    assert solution.converged
    assert solution.sum_of_squares < 0.01 * mean_square(problem, *start)
    y = np.r_[solution.p, solution.q[1:]]

    def r(v):
        return residual(problem, v[: len(solution.p)], np.r_[1.0, v[len(solution.p) :]])

    h = 1e-6
    jacobian = np.stack([(r(y + e) - r(y - e)) / (2 * h) for e in h * np.eye(len(y))], axis=1)
    cosine = jacobian.T @ r(y) / (np.linalg.norm(jacobian, axis=0) * np.linalg.norm(r(y)))
    assert np.abs(cosine).max() < 1e-4


def test_the_denominator_stays_positive_on_rows_and_guards(problem, solution):
    assert solution.q[0] == 1.0
    assert (problem.columns[1] @ solution.q).min() > 0.0
    assert (problem.guards @ solution.q).min() > 0.0


def test_no_step_crosses_a_pole(make_table, unit_axis):
    """1 / (x - 0.37) is rational of degree 1: only the refusal of Q <= 0 keeps a descent from it."""
    problem = Problem.of_table(
        make_table(lambda x: 1.0 / (x - 0.37), unit_axis("r", 32)), Rational(1).terms(1)
    )
    found = solve(problem, polynomial_start(problem), rtol=1e-9, max_steps=300)
    assert (problem.columns[1] @ found.q).min() > 0.0
    assert (problem.guards @ found.q).min() > 0.0
    assert found.sum_of_squares > 1.0


def test_too_few_steps_are_not_called_converged(problem, start):
    cut = solve(problem, start, rtol=1e-10, max_steps=2)
    assert not cut.converged
    assert cut.steps <= 2
    assert cut.sum_of_squares <= mean_square(problem, *start)


def test_a_barrier_pushes_the_denominator_up(problem, start, solution):
    held = solve(problem, start, barrier=1.0, rtol=1e-6, max_steps=300)
    assert (problem.guards @ held.q).min() > (problem.guards @ solution.q).min()
    assert held.sum_of_squares >= solution.sum_of_squares


def test_blocks_of_rows_make_no_difference(make_table, unit_axis):
    """95 x 95 rows take two blocks, the second mostly padding; weights stand for repeated rows."""

    def f(x, y):
        return (1.0 + x) / (1.0 + 0.5 * x + y)

    table = make_table(f, unit_axis("r", 95), unit_axis("mu", 95))
    problem = Problem.of_table(table, Rational(1).terms(2))
    assert problem.rows > 8192
    found = solve(problem, polynomial_start(problem), rtol=1e-9, max_steps=200)
    plain = problem.plain_coefficients(found.p, found.q)
    np.testing.assert_allclose(plain, [1.0, 1.0, 0.0, 0.5, 1.0], atol=1e-6)


def test_a_linear_solution_has_no_denominator(make_table, unit_axis):
    problem = Problem.of_table(make_table(lambda x: 2.0 * x, unit_axis("r", 5)), Polynomial(1).terms(1))
    found = linear_solution(problem)
    assert found.converged
    assert found.sum_of_squares < 1e-28
    np.testing.assert_array_equal(found.q, [1.0])
