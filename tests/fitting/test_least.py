"""The least possible largest error beside a fit: 0 for exact forms, reached by minimax, missed by others."""

import json

import numpy as np
import pytest

import ecfit
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.fitting.minimax import minimax
from ecfit.forms import ModuleForm

pytest.importorskip("scipy")

RATIO = {"head": "ratio", "features": ("mu",), "numerators": [[[0], [1]]], "denominator": [[0], [1]]}


@pytest.fixture(scope="module")
def table(make_table) -> ecfit.Table:
    return make_table(lambda mu: np.exp(-2.0 * mu) + 0.1 * np.sin(5.0 * mu), Axis.spaced("mu", 120))


def fitted(table, norm: str, **settings) -> ecfit.Fit:
    return ecfit.fit(table, ecfit.Structured(**RATIO), norm=norm, lower_bound=True, **settings)


def test_minimax_reaches_the_bound_and_least_squares_does_not(table):
    best, usual = fitted(table, "minimax"), fitted(table, "least-squares")
    assert best.max_over_least == pytest.approx(1.0, abs=1e-6)
    assert best.least_tight
    assert usual.max_over_least is not None
    assert usual.max_over_least > 1.05
    assert usual.least_max_error == pytest.approx(best.least_max_error, rel=1e-5)
    assert usual.least_note() == f"{usual.max_over_least:.3g}"


def test_a_line_on_three_points_by_hand(make_table):
    """The best line through 0, 0, 1 at 0, 0.5, 1 is off by 0.25."""
    table = make_table(lambda mu: np.where(mu > 0.9, 1.0, 0.0), Axis.given("mu", [0.0, 0.5, 1.0]))
    fit = ecfit.fit(table, ecfit.Polynomial(1), lower_bound=True)
    assert fit.least_max_error == pytest.approx(0.25, rel=1e-6)
    assert fit.max_over_least == pytest.approx(fit.max_error / 0.25, rel=1e-6)


def test_an_exact_form_has_the_bound_0(make_table):
    table = make_table(lambda mu: (0.9 - 0.3 * mu) / (1.0 + 0.8 * mu), Axis.spaced("mu", 40))
    for form in (ecfit.Structured(**RATIO), ecfit.Rational(1)):
        fit = ecfit.fit(table, form, lower_bound=True)
        assert fit.least_max_error is not None
        assert 0.0 <= fit.least_max_error < 1e-8
        assert fit.least_tight


def test_a_rational_and_its_structured_form_have_one_bound(table):
    fit = ecfit.fit(table, ecfit.Rational(1), lower_bound=True)
    assert fit.least_max_error == pytest.approx(fitted(table, "minimax").least_max_error, rel=1e-5)


def test_margins_and_rounded_digits_are_seen(make_table):
    """E <= 1 with a margin of 0.1 under a table of 0.95: no fit comes nearer than 0.05."""
    table = make_table(lambda mu: 0.95 - 0.0 * mu, Axis.spaced("mu", 20))
    bounded = {"name": "bounded", "factors": [{}], "text": "1 - X", "deficit": "X"}
    form = ecfit.Structured(**{**RATIO, "head": bounded})
    fit = ecfit.fit(table, form, norm="minimax", margin=0.1, digits=4, lower_bound=True)
    assert fit.least_max_error == pytest.approx(0.05, rel=1e-5)
    assert fit.max_over_least == pytest.approx(1.0, rel=1e-2)


def test_a_program_that_is_cut_short_bounds_nothing(curve, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("ecfit.fitting.minimax._PROGRAMS", 1)
    problem = curve(lambda mu: np.exp(-2.0 * mu) + 0.1 * np.sin(5.0 * mu))
    for proved in (False, True):
        found = minimax(problem.descent, problem.support, 0, np.array([1.0, 0.0, 0.5]), proved=proved)
        assert not found.converged
        assert found.bound == 0.0


def test_it_is_in_the_file_only_where_it_is_known(table):
    fit = fitted(table, "least-squares")
    again = ecfit.Fit.from_dict(json.loads(json.dumps(fit.to_dict())))
    assert (again.least_max_error, again.least_tight) == (fit.least_max_error, True)
    data = fit.to_dict()
    data["fit"]["least_tight"] = False
    loose = ecfit.Fit.from_dict(data)
    assert loose.least_note().startswith("at most ")
    assert loose.to_dict() == data
    plain = ecfit.fit(table, ecfit.Structured(**RATIO))
    assert "least_max_error" not in plain.to_dict()["fit"]
    assert plain.max_over_least is None
    assert plain.least_note() == ""


def test_what_it_is_not_for_is_told(table, monkeypatch: pytest.MonkeyPatch):
    two = {"name": "two", "factors": [{}, {}], "text": "X1*X2"}
    pair = ecfit.Structured(**{**RATIO, "head": two, "numerators": RATIO["numerators"] * 2})
    with pytest.raises(EcfitError, match="heads of one ratio; 'two' has 2: leave it out"):
        ecfit.fit(table, pair, lower_bound=True)
    square = ecfit.Structured(**{**RATIO, "head": {"name": "square", "factors": [{}], "text": "X*X"}})
    with pytest.raises(EcfitError, match="linear in their ratio, not 'square': leave it out"):
        ecfit.fit(table, square, lower_bound=True)
    with pytest.raises(EcfitError, match="forms with terms, not for modules"):
        ecfit.fit(table, ModuleForm.__new__(ModuleForm), lower_bound=True)
    with pytest.raises(EcfitError, match="lower_bound must be true or false"):
        ecfit.fit(table, ecfit.Polynomial(1), lower_bound=1)
    monkeypatch.setattr("ecfit.fitting.least.find_spec", lambda name: None)
    with pytest.raises(EcfitError, match=r"lower_bound needs SciPy: pip install 'ecfit\[minimax\]'"):
        ecfit.fit(table, ecfit.Polynomial(1), lower_bound=True)
