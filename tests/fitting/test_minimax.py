"""The minimax fit: the error alternates, no other coefficients do better, and limits are kept."""

import builtins

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.fitting.minimax import minimax
from ecfit.forms.structured import head_from

pytest.importorskip("scipy")

START = np.array([1.0, 0.0, 0.5])


def curved(mu):
    return np.exp(-2.0 * mu) + 0.1 * np.sin(5.0 * mu)


def error_of(problem, c, relative: bool = False) -> np.ndarray:
    value = problem.descent.value(problem.support, 0, c)[0]
    y = problem.descent.target.values
    return y / value - 1.0 if relative else value - y


@pytest.fixture(scope="module")
def solved(curve):
    problem = curve(curved)
    return problem, minimax(problem.descent, problem.support, 0, START)


def test_the_error_alternates_between_its_extremes(solved):
    """Chebyshev: the optimum of n coefficients takes its maximum n + 1 times with alternating signs."""
    problem, found = solved
    e = error_of(problem, found.coefficients)
    peaks = np.sign(e[np.abs(e) > found.error * (1.0 - 1e-6)])
    assert found.converged
    assert np.abs(e).max() == pytest.approx(found.error, rel=1e-9)
    assert 1 + np.count_nonzero(np.diff(peaks)) >= 4


@pytest.mark.parametrize("relative", [False, True])
def test_no_other_coefficients_have_a_smaller_maximum(curve, relative: bool):
    problem = curve(lambda mu: 0.3 + 0.5 * curved(mu))
    found = minimax(problem.descent, problem.support, 0, START, relative=relative)
    assert found.bound <= found.error <= found.bound * (1.0 + 1e-4)
    rng = np.random.default_rng(0)
    for size in 10.0 ** rng.uniform(-4, 0, 300):
        moved = found.coefficients + size * rng.normal(size=3)
        if np.isfinite(problem.descent.rms(problem.support, 0, moved)):
            assert np.abs(error_of(problem, moved, relative)).max() >= found.error * (1.0 - 1e-6)


def test_every_start_leads_to_the_one_optimum(solved):
    problem, found = solved
    for start in ([0.1, 0.1, 0.1], [3.0, 2.0, 10.0], [1.0, 0.0, -0.9]):
        other = minimax(problem.descent, problem.support, 0, np.array(start))
        assert other.error == pytest.approx(found.error, rel=1e-4)
        np.testing.assert_allclose(other.coefficients, found.coefficients, rtol=1e-2)


def test_only_the_rows_that_count_do(curve):
    spike = np.where(np.arange(120) == 60, 1.0, 0.0)
    problem = curve(lambda mu: (0.9 - 0.3 * mu) / (1.0 + 0.8 * mu) + spike)
    found = minimax(problem.descent, problem.support, 0, START, rows=spike == 0.0)
    assert found.error < 1e-6
    assert minimax(problem.descent, problem.support, 0, START).error > 0.3


BOUNDED = head_from({"name": "bounded", "factors": [{}], "text": "1 - X", "deficit": "X"})


def test_limits_are_kept_even_where_the_start_breaks_them(curve):
    """1.1 at mu = 0 from a start that is exact: the least error within E <= 1 is 0.1."""
    problem = curve(lambda mu: 1.1 - 0.3 * mu, name=BOUNDED)
    start = np.array([-0.1, 0.3, 0.0])
    assert problem.descent.rms(problem.support, 0, start) < 1e-12
    found = minimax(problem.descent, problem.support, 0, start)
    assert found.converged
    assert found.error == pytest.approx(0.1, rel=1e-6)
    mu = np.linspace(0.0, 1.0, 500)
    a, b, c = found.coefficients
    assert np.all((a + b * mu) / (1.0 + c * mu) >= -1e-9)


def test_the_denominator_stays_positive_on_the_closed_domain(curve):
    """The best quotient on mu >= 0.31 has its pole at 0.3: rows below do not count, guards do."""
    problem = curve(lambda mu: 0.02 / (mu - 0.3035))
    rows = problem.table.axes[0].nodes > 0.31
    found = minimax(problem.descent, problem.support, 0, np.array([0.1, 0.1, 0.1]), rows=rows)
    q = 1.0 + found.coefficients[2] * np.linspace(0.0, 1.0, 500)
    assert q.min() > 0.0
    assert found.error > 0.1


def test_limits_that_contradict_each_other_are_not_called_converged(curve):
    nowhere = head_from({"name": "nowhere", "factors": [{}], "text": "X", "deficit": "0*X - 1"})
    problem = curve(curved, name=nowhere)
    found = minimax(problem.descent, problem.support, 0, START)
    assert not found.converged
    assert found.bound < found.error


def test_what_it_needs_is_told(curve, monkeypatch: pytest.MonkeyPatch):
    problem = curve(curved)
    square = curve(curved, name=head_from({"name": "s", "factors": [{}], "text": "X*X"}))
    with pytest.raises(EcfitError, match="minimax is for heads of one ratio.*'s'"):
        minimax(square.descent, square.support, 0, START)
    real = builtins.__import__

    def without(name, *rest, **more):
        if name.startswith("scipy"):
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(EcfitError, match=r"minimax needs SciPy: pip install 'ecfit\[minimax\]'"):
        minimax(problem.descent, problem.support, 0, START)
