"""Descents end at minima, and the first-order gains and losses are those of the linearised problem."""

import numpy as np
import pytest

from ecfit.forms.structured import head_from

TRUE = np.array([0.9, -0.3, 0.8])  # (0.9 - 0.3 mu) / (1 + 0.8 mu)


def exact(mu):
    return (0.9 - 0.3 * mu) / (1.0 + 0.8 * mu)


def curved(mu):
    return np.exp(-2.0 * mu) + 0.1 * np.sin(5.0 * mu)


def jacobian(descent, support, c) -> np.ndarray:
    """Weighted, by central differences."""
    columns = []
    for i in range(len(c)):
        step = np.zeros(len(c))
        step[i] = 1e-6
        up, down = (descent.value(support, 0, c + s * step)[0] for s in (1.0, -1.0))
        columns.append((up - down) / 2e-6 * descent.root_w)
    return np.stack(columns, axis=1)


def residual(descent, support, c) -> np.ndarray:
    return (descent.value(support, 0, c)[0] - descent.target.values) * descent.root_w


@pytest.fixture(scope="module")
def solved(curve):
    """(problem, coefficients at its minimum)."""
    problem = curve(curved)
    found = problem.descent.solve(problem.support, 0, np.array([1.0, 0.0, 0.5]), rtol=1e-10, max_steps=200)
    assert found.converged
    return problem, found


def test_coefficients_are_recovered_from_afar(curve):
    problem = curve(exact)
    for start in ([0.1, 0.1, 0.1], [5.0, 5.0, 5.0]):
        found = problem.descent.solve(problem.support, 0, np.array(start), rtol=1e-10, max_steps=300)
        assert found.converged
        np.testing.assert_allclose(found.coefficients, TRUE, atol=1e-6)
        assert found.rms < 1e-7


def test_the_end_is_a_minimum(solved):
    problem, found = solved
    rng = np.random.default_rng(0)
    least = problem.descent.rms(problem.support, 0, found.coefficients)
    assert least == pytest.approx(found.rms, rel=1e-9)
    for size in (1e-1, 1e-2, 1e-3):
        for _ in range(50):
            moved = found.coefficients * (1.0 + size * rng.normal(size=3))
            assert problem.descent.rms(problem.support, 0, moved) >= least * (1.0 - 1e-12)


def test_the_slopes_are_those_of_the_value(solved):
    problem, found = solved
    descent, support, c = problem.descent, problem.support, found.coefficients
    _, slopes, ratios, q = descent.value(support, 0, c)
    p_part = descent.columns[0][:, support[0]] * (slopes[0] / q)[:, None]
    q_part = -descent.columns[1][:, support[1]] * (slopes[0] * ratios[0] / q)[:, None]
    analytic = np.concatenate([p_part, q_part], axis=1) * descent.root_w[:, None]
    np.testing.assert_allclose(analytic, jacobian(descent, support, c), atol=1e-9)


def test_the_gain_is_what_a_term_takes_from_the_linearised_problem(solved):
    problem, found = solved
    descent, support, c = problem.descent, problem.support, found.coefficients
    r = residual(descent, support, c)

    def left(more: list[list[int]]) -> float:
        """Least sum of squares of r + J d over d, with more columns."""
        j = jacobian(
            descent,
            more,
            np.concatenate([c[:2], np.zeros(len(more[0]) - 2), c[2:], np.zeros(len(more[1]) - 1)]),
        )
        return float(np.sum((r - j @ np.linalg.lstsq(j, r, rcond=None)[0]) ** 2))  # fmt: skip

    gains = descent.gains(support, 0, c)
    base = left(support)
    for k in (2, 3):
        assert gains[0][k] == pytest.approx(base - left([[0, 1, k], [1]]), rel=1e-4)
        assert gains[1][k] == pytest.approx(base - left([[0, 1], [1, k]]), rel=1e-4)
    # What the form has is never a candidate.
    assert gains[0][:2].tolist() == [-1.0, -1.0]
    assert gains[1][:2].tolist() == [-1.0, -1.0]


def test_the_loss_is_what_a_term_held_up_in_the_linearised_problem(solved):
    problem, found = solved
    descent, support, c = problem.descent, problem.support, found.coefficients
    j, r = jacobian(descent, support, c), residual(descent, support, c)
    for i, loss in enumerate(descent.losses(support, 0, c)):
        others = np.delete(j, i, axis=1)
        without = r - c[i] * j[:, i]
        without = without - others @ np.linalg.lstsq(others, without, rcond=None)[0]
        assert loss == pytest.approx(float(without @ without - r @ r), rel=1e-4)


@pytest.mark.filterwarnings("error")
def test_the_linearised_start_is_exact_for_exact_data(curve):
    problem = curve(exact)
    np.testing.assert_allclose(problem.descent.linearised(problem.support, 0), TRUE, atol=1e-8)
    # Q led by a term that vanishes at a node: (1 + mu) / (mu + 0.5), as mu / (...) with the constant free.
    other = curve(lambda mu: (0.45 - 0.15 * mu) / (mu + 0.5))
    start = other.descent.linearised([[0, 1], [0]], 1)
    np.testing.assert_allclose(start, [0.45, -0.15, 0.5], atol=1e-8)


def test_the_linearised_start_has_a_positive_denominator_or_is_none(curve):
    problem = curve(lambda mu: 0.1 / (mu - 0.3035))  # a pole between the nodes
    start = problem.descent.linearised(problem.support, 0)
    assert start is None or np.isfinite(problem.descent.rms(problem.support, 0, start))


def test_heads_that_are_affine_in_the_ratio(curve):
    base, slope = curve(exact).descent.affine
    np.testing.assert_array_equal(base, 0.0)
    np.testing.assert_array_equal(slope, 1.0)
    product = head_from({"name": "p", "factors": [{"mu": 1}], "text": "0.5 - 2*X"})
    problem = curve(exact, name=product)
    base, slope = problem.descent.affine
    np.testing.assert_array_equal(base, 0.5)
    np.testing.assert_allclose(slope, -2.0 * problem.table.axes[0].nodes)
    square = head_from({"name": "s", "factors": [{}], "text": "X*X"})
    problem = curve(exact, name=square)
    assert problem.descent.affine is None
    assert problem.descent.linearised(problem.support, 0) is None


def test_a_denominator_without_a_sign_has_an_infinite_residual(curve):
    descent, support = curve(exact).descent, [[0], [1]]
    assert np.isfinite(descent.rms(support, 0, np.array([1.0, -0.99])))
    assert descent.rms(support, 0, np.array([1.0, -1.01])) == np.inf


def test_the_order_of_the_terms_is_immaterial(solved):
    problem, found = solved
    start = np.array([0.0, 1.0, 0.5])
    other = problem.descent.solve([[1, 0], [1]], 0, start, rtol=1e-10, max_steps=200)
    np.testing.assert_allclose(other.coefficients[[1, 0, 2]], found.coefficients, rtol=1e-5)


def test_a_ridge_shrinks_coefficients(curve):
    problem = curve(curved)
    sizes = [
        np.linalg.norm(
            problem.descent.solve(
                problem.support, 0, np.array([1.0, 0.0, 0.5]), rtol=1e-8, max_steps=200, ridge=ridge
            ).coefficients
        )
        for ridge in (0.0, 1e-2, 1e-1, 1.0)
    ]
    assert np.all(np.diff(sizes) < 0.0)
