"""The least-squares problem: its basis, its thinning and the way back to plain monomials."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.coordinates import Axis
from ecfit.fitting.problem import Problem, blocks, chebyshev_powers, from_unit_monomials, thin
from ecfit.forms import Polynomial, Rational


@given(
    variables=st.integers(1, 3),
    degree=st.integers(1, 4),
    seed=st.integers(0, 10_000),
)
def test_plain_coefficients_are_the_same_function(variables, degree, seed, make_table):
    """On a domain that is not the unit box, with the denominator's constant divided out."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1.0, 0.5, variables)
    axes = [
        Axis.given(n, v + np.linspace(0.0, 1.0 + i, degree + 2))
        for i, (n, v) in enumerate(zip("abc", low, strict=False))
    ]
    problem = Problem.of_table(make_table(lambda *x: x[0], *axes), Rational(degree).terms(variables))
    p = rng.normal(size=len(problem.terms.numerator))
    q = np.r_[3.0, 0.1 * rng.normal(size=len(problem.terms.denominator))]
    columns_p, columns_q = problem.columns
    nominal = [problem_axis.nominal[i] for problem_axis, i in zip(axes, problem.index, strict=True)]
    plain = problem.plain_coefficients(p, q)
    numerator, denominator = problem.terms.parts(plain, nominal)
    scale = columns_q @ q / np.asarray(denominator)  # Q(0), the constant that was divided out
    np.testing.assert_allclose(scale, scale[0], rtol=1e-7)
    np.testing.assert_allclose(
        numerator / denominator, columns_p @ p / (columns_q @ q), atol=1e-7 * np.abs(plain).max()
    )


def test_a_denominator_that_vanishes_at_the_origin_has_no_plain_form(make_table, unit_axis):
    problem = Problem.of_table(make_table(lambda x: x, unit_axis("r", 5)), Rational(1).terms(1))
    # Q = 1 + T1 = 2 x on [0, 1].
    assert not np.all(np.isfinite(problem.plain_coefficients(np.ones(2), np.ones(2))))


def test_the_basis_is_bounded_by_one_on_the_domain():
    x = np.linspace(0.2, 3.0, 50)
    values = chebyshev_powers(x, 0.2, 3.0, 12)
    assert np.abs(values).max() <= 1.0 + 1e-14
    np.testing.assert_allclose(values[-1], 1.0, rtol=1e-14)
    np.testing.assert_allclose(values[0], (-1.0) ** np.arange(13), rtol=1e-14)


def test_rows_are_the_tables_entries_at_nominal_coordinates(make_table):
    r, mu = Axis.spaced("r", 4, 0.3, 0.9, "clamped"), Axis.given("mu", [0.1, 0.5, 0.9])
    problem = Problem.of_table(make_table(lambda r, m: 10 * r + m, r, mu), Polynomial(1).terms(2))
    assert problem.rows == 12
    np.testing.assert_array_equal(problem.weights, 1.0)
    expected = 10 * r.nominal[problem.index[0]] + mu.nodes[problem.index[1]]
    np.testing.assert_allclose(problem.values, expected)


@pytest.mark.parametrize(("count", "nodes"), [(1024, 72), (1024, 256), (300, 72), (128, 24), (5000, 1024)])
def test_thinning_sums_polynomials_of_the_index_exactly(count, nodes):
    chosen, weights = thin(count, nodes)
    assert (chosen[0], chosen[-1]) == (0, count - 1)
    assert np.all(np.diff(chosen) > 0)
    assert len(chosen) <= nodes + 2
    assert weights.min() > 0.0
    assert weights.sum() == pytest.approx(count, rel=1e-12)
    x = np.linspace(-1.0, 1.0, count)
    # At least a third of the nodes' number of degrees: what makes smooth residuals exact to rounding.
    basis = np.polynomial.chebyshev.chebvander(x, nodes // 3)
    np.testing.assert_allclose(weights @ basis[chosen], basis.sum(axis=0), atol=1e-9 * count)


def test_a_thinned_problem_has_the_sums_of_the_whole_one(make_table, unit_axis):
    def f(x, y):
        return (1.0 + x * y) / (1.3 + x) + np.sin(3.0 * y)

    whole = Problem.of_table(make_table(f, unit_axis("r", 400), unit_axis("mu", 300)), Polynomial(3).terms(2))
    few = whole.thinned(72)
    assert few.rows <= 74 * 74 < whole.rows
    assert few.weights.sum() == pytest.approx(whole.rows, rel=1e-12)
    for power in (1, 2):
        assert few.weights @ few.values**power == pytest.approx(np.sum(whole.values**power), rel=1e-11)


def test_small_problems_are_used_whole(make_table, unit_axis):
    problem = Problem.of_table(
        make_table(lambda x, y: x, unit_axis("r", 30), unit_axis("mu", 20)), Polynomial(1).terms(2)
    )
    same = problem.thinned(30)
    assert same.rows == problem.rows
    np.testing.assert_array_equal(same.weights, 1.0)


@pytest.mark.parametrize("variables", [1, 2, 3])
def test_guards_reach_the_corners(variables, make_table, unit_axis):
    axes = [unit_axis(n, 4) for n in "abc"[:variables]]
    problem = Problem.of_table(make_table(lambda *x: x[0], *axes), Rational(1).terms(variables))
    linear = problem.guards[:, 1:]  # T1 of each variable
    for corner in np.array(np.meshgrid(*[[-1.0, 1.0]] * variables)).reshape(variables, -1).T:
        assert np.any(np.all(np.abs(linear - corner) < 1e-12, axis=1))


@pytest.mark.parametrize(("rows", "size"), [(10, 4), (8, 4), (3, 4)])
def test_blocks_are_padded_with_zero_weights(rows, size):
    values, weights = blocks([np.arange(1.0, rows + 1), np.ones(rows)], size)
    assert values.shape == weights.shape
    assert values.shape[1] == size
    assert weights.sum() == rows
    np.testing.assert_array_equal(values.ravel()[:rows], np.arange(1.0, rows + 1))


def test_a_full_grid_is_evaluated_as_its_rows_are(make_table, unit_axis):
    axes = [unit_axis(n, 4 + i) for i, n in enumerate("abc")]
    problem = Problem.of_table(make_table(lambda *x: x[0], *axes), Polynomial(3).terms(3))
    assert problem.full
    p = np.random.default_rng(0).normal(size=len(problem.terms.numerator))
    found = problem.on_grid(p, problem.terms.numerator)
    assert found.shape == (4, 5, 6)
    np.testing.assert_allclose(found.ravel(), problem.columns[0] @ p, rtol=1e-12, atol=1e-13)


def test_a_table_with_gaps_and_a_thinned_one_are_not_full(make_table, unit_axis):
    table = make_table(lambda x: np.where(x == 0.0, np.nan, x), unit_axis("r", 5))
    problem = Problem.of_table(table, Polynomial(1).terms(1))
    assert problem.rows == 4
    assert not problem.full
    whole = Problem.of_table(make_table(lambda x: x, unit_axis("r", 300)), Polynomial(1).terms(1))
    assert whole.full
    assert not whole.thinned(72).full


def test_watched_places_are_guarded(make_table, unit_axis):
    """They come behind the guards' own grid, and stay when the problem is thinned."""
    axes = [Axis.given(n, np.linspace(1.0, 3.0, 40)) for n in "ab"]
    problem = Problem.of_table(make_table(lambda x, y: x, *axes), Rational(2).terms(2))
    place = (1.25, 2.6)
    for watching in (problem.watching(place), problem.watching(place).thinned(8)):
        assert watching.watched == (place,)
        assert len(watching.guards) == len(problem.guards) + 1
        # x and y in [-1, 1], by hand: -0.75 and 0.6; T2 = 2 x^2 - 1.
        x, y = -0.75, 0.6
        expected = [1.0, x, y, 2.0 * x * x - 1.0, x * y, 2.0 * y * y - 1.0]
        np.testing.assert_allclose(watching.guards[-1], expected, rtol=1e-12)
    assert problem.watching(place).watching((1.0, 1.0)).watched == (place, (1.0, 1.0))


def test_unit_monomials_are_powers_of_the_variable_in_its_range():
    x = np.linspace(-1.0, 1.0, 9)
    basis = np.polynomial.chebyshev.chebvander(x, 4)
    powers = (0.5 * (x + 1.0))[:, None] ** np.arange(5)
    np.testing.assert_allclose(basis @ from_unit_monomials(4).T, powers, atol=1e-15)
