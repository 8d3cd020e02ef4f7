"""`ecfit.fit` with structured and selected forms: recovery, limits, honest status, clear refusals."""

import dataclasses
import json

import numpy as np
import pytest

import ecfit
from ecfit.coordinates import Axis

CONDUCTOR = {
    "head": "corner",
    "features": ("alpha", "mu"),
    "numerators": [[[1, 0], [0, 1], [3, 0], [2, 1], [3.5, 0], [0.5, 3]]],
    "denominator": [[3, 0], [0, 3], [1.5, 1.5], [4.5, 1.5], [0.5, 3]],
}
COEFFICIENTS = np.array(
    [0.06256, 0.11125, 0.89389, 0.55689, -0.57248, 0.20031, 0.17076, 0.32043, 0.36454, -0.05526]
)
AXES = Axis.spaced("r", 12), Axis.spaced("mu", 12)


def conductor(r, mu):
    """The reference form by hand; E = 1 at alpha = 0."""
    alpha, mu = np.maximum(r * r, 1e-300), np.maximum(mu, 1e-300)
    p = sum(c * alpha**a * mu**b for c, (a, b) in zip(COEFFICIENTS, CONDUCTOR["numerators"][0], strict=False))
    q = sum(
        c * alpha**a * mu**b
        for c, (a, b) in zip([1.0, *COEFFICIENTS[6:]], CONDUCTOR["denominator"], strict=True)
    )
    with np.errstate(invalid="ignore"):
        return np.where(r == 0.0, 1.0, 1.0 - alpha**2 * p / q)


@pytest.fixture(scope="module")
def exact(make_table) -> ecfit.Table:
    """With alpha = 0, mu = 0 and both among the nodes."""
    return make_table(conductor, *AXES)


@pytest.fixture(scope="module")
def fitted(exact) -> ecfit.Fit:
    return ecfit.fit(exact, ecfit.Structured(**CONDUCTOR), name="ours")


def test_ten_coefficients_are_recovered(fitted):
    assert fitted.ok
    assert fitted.max_error < 5e-5
    np.testing.assert_allclose(fitted.coefficients, COEFFICIENTS, atol=1e-3)
    assert fitted.smallest.bound > 0.05
    assert fitted.approximation.variables == ("mu", "alpha")
    assert fitted.approximation.domain == ((0.0, 1.0), (0.0, 1.0))


def test_limits_hold_at_the_corner_in_every_view(fitted):
    mu = np.linspace(0.0, 1.0, 7)
    np.testing.assert_array_equal(fitted(mu=mu, alpha=0.0), 1.0)
    np.testing.assert_allclose(fitted(mu=mu, r=0.5), fitted(mu=mu, alpha=0.25), rtol=1e-15)


def test_a_fit_reads_back_exactly(fitted, tmp_path):
    fitted.save(tmp_path / "fit.json")
    again = ecfit.Fit.load(tmp_path / "fit.json")
    assert json.dumps(again.to_dict()) == json.dumps(fitted.to_dict())
    np.testing.assert_array_equal(again.coefficients, fitted.coefficients)
    assert again(mu=0.3, alpha=0.2) == fitted(mu=0.3, alpha=0.2)


def test_digits_round_the_coefficients(exact, fitted):
    rounded = ecfit.fit(exact, ecfit.Structured(**CONDUCTOR), digits=3)
    expected = [float(f"{c:.3g}") for c in fitted.coefficients]
    np.testing.assert_array_equal(rounded.coefficients, expected)
    # Errors are those of the rounded coefficients.
    value = rounded.approximation.on_grid([AXES[1].nodes, AXES[0].nodes ** 2]).T
    assert rounded.max_error == pytest.approx(np.abs(value - exact.values).max(), rel=1e-9)
    assert rounded.max_error > 10.0 * fitted.max_error


def test_the_minimax_fit_is_no_worse_than_the_reference_on_the_conductor(exact):
    """Of the conductor itself: the reference's error is 2.5e-3 on these nodes, of which more than half is
    not needed."""
    table = ecfit.tabulate("conductor", {"r": AXES[0], "mu": AXES[1]}, tolerance=1e-6)
    reference = np.abs(exact.values - table.values).max()
    fit = ecfit.fit(table, ecfit.Structured(**CONDUCTOR), norm="minimax")
    squares = ecfit.fit(table, ecfit.Structured(**CONDUCTOR))
    assert fit.ok
    assert fit.max_error < 0.5 * reference
    assert fit.max_error < squares.max_error
    assert squares.rmse < fit.rmse


SIMPLE = {
    "head": "corner",
    "features": ("alpha", "mu"),
    "numerators": [[[0, 1], [0, 0]]],
    "denominator": [[0, 0], [0, 1]],
}


def test_a_fit_that_would_exceed_1_is_held(make_table):
    table = make_table(lambda r, mu: 1.0 - r**4 * (0.5 * mu - 0.1) / (1.0 + mu), *AXES)
    free = ecfit.fit(table, ecfit.Structured(**SIMPLE), strength=0.0)
    assert free.prediction[1] == pytest.approx(1.1, abs=1e-6)
    held = [ecfit.fit(table, ecfit.Structured(**SIMPLE), strength=s).prediction[1] for s in (1.0, 100.0)]
    assert 1.0 < held[0] < 1.05
    assert held[1] < 1.0001
    assert ecfit.fit(table, ecfit.Structured(**SIMPLE), norm="minimax").prediction[1] <= 1.0 + 1e-9


def test_a_fit_whose_optimum_has_a_pole_is_kept_from_it(make_table):
    """0.02 / (mu - 0.1) on mu >= 0.2: the pole is outside the table, but in [0, 1]."""
    table = make_table(lambda mu: 0.02 / (mu - 0.1), Axis.spaced("mu", 24, 0.2, 1.0))
    form = ecfit.Structured("ratio", ("mu",), [[[0]]], [[1], [0]])
    free = ecfit.fit(table, form, strength=0.0)
    assert free.status == "pole"
    assert "HAS A POLE" in free.warning()
    assert free.max_error < 1e-6
    held = ecfit.fit(table, form)
    assert held.ok
    assert held.smallest.bound > 0.0
    assert held.max_error > 1e-3


def test_a_head_of_ones_own_is_fitted(make_table):
    """1 - (1 - X)^2 of X = alpha (0.3 + 0.5 mu) / (1 + mu): no head of ours, and not affine."""
    head = {
        "name": "mine",
        "factors": [{"alpha": 1}],
        "lets": [["y", "1 - X"]],
        "text": "y*y",
        "deficit": "X + X*y",
    }
    table = make_table(lambda r, mu: (1.0 - r * r * (0.3 + 0.5 * mu) / (1.0 + mu)) ** 2, *AXES)
    form = ecfit.Structured(head, ("mu",), [[[0], [1]]], [[0], [1]])
    fit = ecfit.fit(table, form)
    assert fit.ok
    np.testing.assert_allclose(fit.coefficients, [0.3, 0.5, 1.0], atol=1e-4)
    again = ecfit.Approximation.from_dict(json.loads(json.dumps(fit.approximation.to_dict())))
    assert again.to_dict() == fit.approximation.to_dict()


def test_a_selected_form_finds_its_terms(make_table):
    bounds = {"highest": {"alpha": 1, "mu": 2}}
    form = ecfit.Selected("corner", ("alpha", "mu"), [bounds], bounds, budget=3, rounds=2)
    table = make_table(lambda r, mu: 1.0 - r**4 * (0.5 + 0.2 * mu**2) / (1.0 + mu), *AXES)
    fit = ecfit.fit(table, form)
    assert fit.ok
    assert fit.max_error < 1e-5
    assert fit.approximation.count == 3
    # alpha and mu are the form's variables even where no term needs them.
    assert fit.approximation.variables == ("mu", "alpha")


def test_bad_tables_and_settings_are_told(exact, make_table):
    form = ecfit.Structured(**CONDUCTOR)
    values = exact.values.copy()
    values[2, 3] = np.nan
    curve = make_table(lambda r: 1.0 - r**4, AXES[0])
    cube = make_table(
        lambda r, mu, f: r + mu + f, Axis.spaced("r", 3), Axis.spaced("mu", 3), Axis.spaced("F0", 3)
    )
    few = make_table(lambda r, mu: r + mu, Axis.spaced("r", 3), Axis.spaced("mu", 3))
    cases = [
        (dataclasses.replace(exact, values=values), {}, "1 of 144 entries that are NaN or infinite"),
        (curve, {}, "function of mu, alpha, the table of r: choose features of the table's coordinates"),
        (cube, {}, "function of mu, alpha, the table of r, mu, F0"),
        (few, {}, "10 coefficients, but the table only 9 entries"),
        (exact, {"norm": "l2"}, "unknown norm 'l2': expected one of furnace-l4, furnace-max"),
        (exact, {"nrom": "l1"}, "unknown setting of fit 'nrom'.*did you mean 'norm'"),
        (exact, {"digits": 2}, "digits must be an integer in 3..17, got 2"),
        (exact, {"digits": 4.0}, "digits must be an integer"),
        (exact, {"strength": -1.0}, "strength must be a number >= 0"),
        (exact, {"ridge": float("nan")}, "ridge must be a number >= 0"),
        (
            exact,
            {"norm": "minimax", "ridge": 0.1},
            "ridge has no effect in the norm 'minimax'.*use",
        ),
        (exact, {"norm": "furnace-max", "monotone": {"mu": 1}}, "monotone has no effect in the norm 'furn"),
        (exact, {"weights": np.zeros((12, 12))}, "weights must be finite, not negative and not all 0"),
        (exact, {"weights": np.eye(12)[:, :1] * np.eye(12)[0]}, "10 coefficients, but only 1 of 144 entries"),
        (exact, {"monotone": {"F0": 1}}, "no coordinate 'F0': its axes are r, mu"),
        (exact, {"monotone": {"r": 1}}, "monotone: the table's values fall along r, .*ask for {'r': -1}"),
        (exact, {"monotone": {"alpha": 1}}, "monotone: the table's values fall along r"),
    ]
    for table, settings, words in cases:
        with pytest.raises(ecfit.EcfitError, match=words) as caught:
            ecfit.fit(table, form, **settings)
        assert "\n" not in str(caught.value)


def test_a_rational_in_another_norm_begins_from_least_squares(make_table):
    table = make_table(lambda r, mu: 1.0 - r**4 * (0.5 + 0.2 * mu**2) / (1.0 + mu), *AXES)
    squares, minimax = (ecfit.fit(table, ecfit.Rational(1), **s) for s in ({}, {"norm": "minimax"}))
    assert minimax.approximation.count == squares.terms.count
    assert minimax.max_error < squares.max_error
