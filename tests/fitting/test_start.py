"""Starts: each is a good place to descend from."""

import numpy as np

from ecfit.fitting.problem import Problem
from ecfit.fitting.solver import linear_solution, mean_square
from ecfit.fitting.start import embedded, polynomial_start, sanathanan_koerner
from ecfit.forms import Polynomial, Rational


def problem_of(make_table, unit_axis, f, form) -> Problem:
    return Problem.of_table(make_table(f, unit_axis("r", 14), unit_axis("mu", 13)), form.terms(2))


def rational(x, y):
    return (1.0 + 2.0 * x - y + x * y) / (1.0 + 0.5 * x + 3.0 * y * y)


def awkward(x, y):
    return np.sqrt(0.02 + x) * np.exp(-3.0 * y)


def test_linearised_iterations_find_a_rational_function_at_once(make_table, unit_axis):
    problem = problem_of(make_table, unit_axis, rational, Rational(2))
    ((p, q),) = sanathanan_koerner(problem)
    assert mean_square(problem, p, q) ** 0.5 < 1e-12
    assert q[0] == 1.0


def test_linearised_starts_have_no_pole_and_beat_the_polynomial(make_table, unit_axis):
    problem = problem_of(make_table, unit_axis, awkward, Rational(2))
    ((p, q),) = sanathanan_koerner(problem)
    assert (problem.columns[1] @ q).min() > 0.0
    assert (problem.guards @ q).min() > 0.0
    assert mean_square(problem, p, q) < 0.1 * mean_square(problem, *polynomial_start(problem))


def test_the_polynomial_start_is_the_best_polynomial(make_table, unit_axis):
    start = polynomial_start(problem_of(make_table, unit_axis, awkward, Rational(2)))
    best = linear_solution(problem_of(make_table, unit_axis, awkward, Polynomial(2)))
    np.testing.assert_allclose(start[0], best.p, atol=1e-12)
    np.testing.assert_array_equal(start[1], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_an_embedded_start_is_the_same_function(make_table, unit_axis):
    coarse = problem_of(make_table, unit_axis, awkward, Rational(numerator=2, denominator=1))
    fine = problem_of(make_table, unit_axis, awkward, Rational(numerator=3, denominator=2))
    rng = np.random.default_rng(3)
    p, q = rng.normal(size=6), np.r_[1.0, 0.1, -0.2]
    there = mean_square(fine, *embedded(fine, coarse, (p, q)))
    np.testing.assert_allclose(there, mean_square(coarse, p, q), rtol=1e-13)
