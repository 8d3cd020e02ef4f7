"""Linear least squares in blocks against NumPy's."""

from dataclasses import replace

import numpy as np
import pytest

from ecfit.fitting.linear import linear_least_squares
from ecfit.fitting.problem import Problem
from ecfit.forms import Polynomial


@pytest.mark.parametrize(("shape", "degree"), [((9, 8), 3), ((150, 140), 5), ((22, 22), 20)])
def test_normal_equations_in_blocks_give_the_least_squares_solution(shape, degree, make_table, unit_axis):
    """150 x 140 rows take two blocks; degree 20 on 22 nodes has a condition of 3e3."""
    table = make_table(
        lambda x, y: np.exp(x * y) + abs(x - 0.4), unit_axis("r", shape[0]), unit_axis("mu", shape[1])
    )
    problem = Problem.of_table(table, Polynomial(degree).terms(2))
    found = linear_least_squares(problem)
    expected = np.linalg.lstsq(problem.columns[0], problem.values, rcond=None)[0]
    np.testing.assert_allclose(found, expected, atol=1e-11)


def test_weights_count_rows(make_table, unit_axis):
    """A row of weight 2 is a row given twice."""
    axis = unit_axis("r", 6)
    problem = Problem.of_table(make_table(lambda x: np.sqrt(x), axis), Polynomial(2).terms(1))
    twice = np.r_[np.arange(6), 0, 3]
    weights = np.bincount(twice, minlength=6).astype(float)
    weighted = Problem(problem.terms, problem.domain, problem.powers, problem.index, problem.values, weights)
    expected = np.linalg.lstsq(problem.columns[0][twice], problem.values[twice], rcond=None)[0]
    np.testing.assert_allclose(linear_least_squares(weighted), expected, atol=1e-12)


@pytest.mark.parametrize(("counts", "degree"), [((9, 8), 3), ((60, 50), 7), ((6, 7, 8), 3)])
def test_a_full_grid_gives_what_its_rows_give(counts, degree, make_table, unit_axis):
    axes = [unit_axis(n, c) for n, c in zip("abc", counts, strict=False)]
    table = make_table(lambda *x: np.exp(-x[0] * x[1]) + abs(x[-1] - 0.4), *axes)
    problem = Problem.of_table(table, Polynomial(degree).terms(len(counts)))
    assert problem.full
    np.testing.assert_allclose(
        linear_least_squares(problem), linear_least_squares(replace(problem, full=False)), atol=1e-11
    )
