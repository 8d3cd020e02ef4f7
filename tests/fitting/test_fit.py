"""Fits reach the optimum, and say so when they do not."""

import itertools

import numpy as np
import pytest

import ecfit
from ecfit.fitting import Fitter
from ecfit.fitting.problem import Problem, thin
from ecfit.metrics import measure


def synthetic(function, *counts: int, low: float = 0.0) -> ecfit.Table:
    """A table of a function of as many variables in [low, 1]."""
    names = ("r", "mu", "F0")[: len(counts)]
    axes = tuple(ecfit.Axis.spaced(n, c, low, 1.0) for n, c in zip(names, counts, strict=True))
    values = np.asarray(function(*np.meshgrid(*[a.nodes for a in axes], indexing="ij")))
    zeros = np.zeros_like(values)
    return ecfit.Table(values, zeros, zeros, axes, ecfit.Contract("synthetic"), 1e-8)


@pytest.fixture(scope="module")
def clamped() -> ecfit.Table:
    """The 32 x 32 table of configs/conductor-clamped.toml."""
    return ecfit.tabulate(
        "conductor",
        {
            "r": ecfit.Axis.spaced("r", 32, 0.035, 1.0, "clamped"),
            "mu": ecfit.Axis.spaced("mu", 32, 0.02, 1.0, "clamped"),
        },
    )


@pytest.fixture(scope="module")
def cubic(clamped: ecfit.Table) -> ecfit.Fit:
    return ecfit.fit(clamped, ecfit.Rational(degree=3))


def test_a_polynomial_is_recovered_to_rounding():
    table = synthetic(lambda x, y: 0.3 + 2.0 * x - y + 0.5 * x * y * y, 9, 8)
    fit = ecfit.fit(table, ecfit.Polynomial(3))
    assert fit.max_error < 1e-13
    terms = {tuple(e): c for e, c in zip(fit.terms.numerator.tolist(), fit.coefficients, strict=True)}
    assert terms[0, 0] == pytest.approx(0.3, abs=1e-12)
    assert terms[1, 2] == pytest.approx(0.5, abs=1e-11)
    assert terms[3, 0] == pytest.approx(0.0, abs=1e-11)


def test_a_rational_function_is_recovered_with_its_coefficients():
    table = synthetic(lambda x, y: (1.0 + x - 0.5 * y) / (1.0 + 2.0 * x + 0.7 * y), 12, 12)
    fit = ecfit.fit(table, ecfit.Rational(1))
    assert fit.ok
    assert fit.max_error < 1e-9
    np.testing.assert_allclose(fit.coefficients, [1.0, 1.0, -0.5, 2.0, 0.7], atol=1e-7)


def test_three_variables():
    table = synthetic(lambda x, y, z: (1.0 + x * y) / (1.0 + x + z), 8, 8, 8)
    fit = ecfit.fit(table, ecfit.Rational(numerator=2, denominator=1))
    assert fit.terms.count == 13
    assert fit.max_error < 1e-7


def test_separate_degrees():
    table = synthetic(lambda x, y: (1.0 + x * x * y) / (1.0 + y), 10, 10)
    fit = ecfit.fit(table, ecfit.Rational(numerator=3, denominator=1))
    assert fit.max_error < 1e-8
    assert fit.approximation.degree == "3/1"


def test_degree_three_reaches_the_optimum_that_was_published(clamped: ecfit.Table, cubic: ecfit.Fit):
    """RMSE 5.648e-3 and MAE 4.098e-3: Sforza & Pellacini's coefficients, to their five digits."""
    published = ecfit.published("sforza-pellacini-2022-conductor")
    assert cubic.ok
    assert cubic.rmse == pytest.approx(5.6483e-3, abs=1e-7)
    assert cubic.mae == pytest.approx(4.098e-3, abs=1e-6)
    theirs = measure(published, clamped)
    assert cubic.rmse <= theirs.rmse <= cubic.rmse * 1.0001
    size = np.maximum(1.0, np.abs(published.coefficients))
    assert np.max(np.abs(cubic.coefficients - published.coefficients) / size) < 5e-4


def test_no_small_change_of_the_coefficients_is_better(clamped: ecfit.Table, cubic: ecfit.Fit):
    """The gradient of the sum of squares vanishes, relative to that of a step of 1e-5 in one coefficient."""
    terms, c = cubic.terms, cubic.coefficients
    nominal = clamped.grid.nominal_at(np.arange(clamped.grid.size))
    points = [nominal["r"], nominal["mu"]]

    def residual(coefficients: np.ndarray) -> np.ndarray:
        p, q = terms.parts(coefficients, points)
        return p / q - clamped.values.ravel()

    r = residual(c)
    jacobian = np.stack([(residual(c + h) - residual(c - h)) / 2e-6 for h in 1e-6 * np.eye(len(c))], axis=1)
    cosine = jacobian.T @ r / (np.linalg.norm(jacobian, axis=0) * np.linalg.norm(r))
    assert np.max(np.abs(cosine)) < 1e-4


def test_larger_forms_are_not_worse(clamped: ecfit.Table):
    fitter = Fitter(clamped)
    for family in (ecfit.Polynomial, ecfit.Rational):
        errors = [fitter.fit(family(degree)).rmse for degree in (1, 2, 3)]
        assert all(b <= a * 1.000001 for a, b in itertools.pairwise(errors))


def test_a_polynomial_has_no_pole_and_a_status():
    fit = ecfit.fit(synthetic(lambda x: np.exp(x), 12), ecfit.Polynomial(3))
    assert fit.ok
    assert fit.smallest.value == 1.0
    assert fit.warning() == ""


def test_too_few_steps_are_said():
    table = synthetic(lambda x, y: np.sqrt(0.01 + x + y), 12, 12)
    fit = ecfit.fit(table, ecfit.Rational(1), max_steps=1)
    assert fit.status == "not-converged"
    assert "DID NOT CONVERGE" in fit.warning()


def test_the_prediction_range_covers_the_nodes(cubic: ecfit.Fit, clamped: ecfit.Table):
    low, high = cubic.prediction
    assert low <= clamped.values.min() + cubic.max_error
    assert high >= clamped.values.max() - cubic.max_error
    assert high == pytest.approx(
        1.0247, abs=1e-3
    )  # the fit leaves [0, 1] at the corner, as the published one


@pytest.mark.parametrize(
    ("counts", "form", "words"),
    [
        ((3, 3), ecfit.Rational(2), "11 coefficients, but the table only 9 entries"),
        ((3, 20), ecfit.Polynomial(4), "more than 4 nodes on axis 'r'"),
    ],
)
def test_a_table_that_does_not_determine_the_form_is_refused(counts, form, words: str):
    with pytest.raises(ecfit.EcfitError, match=words):
        ecfit.fit(synthetic(lambda x, y: x + y, *counts), form)


def test_entries_that_are_not_finite_are_refused():
    with pytest.raises(ecfit.EcfitError, match="1 of 64 entries that are NaN or infinite"):
        ecfit.fit(synthetic(lambda x, y: np.where((x == 0) & (y == 0), np.nan, x), 8, 8), ecfit.Polynomial(1))


def test_wrong_types_are_refused(clamped: ecfit.Table):
    with pytest.raises(ecfit.EcfitError, match="expects a Table"):
        ecfit.fit(np.zeros((3, 3)), ecfit.Polynomial(1))  # type: ignore[arg-type]
    with pytest.raises(ecfit.EcfitError, match="expects a form"):
        ecfit.fit(clamped, 3)  # type: ignore[arg-type]


def test_a_saved_fit_reads_back(cubic: ecfit.Fit, tmp_path):
    cubic.save(tmp_path / "fit.json")
    again = ecfit.Fit.load(tmp_path / "fit.json")
    assert again.to_dict() == cubic.to_dict()
    np.testing.assert_array_equal(again(mu=0.3, r=0.4), cubic(mu=0.3, r=0.4))
    text = (tmp_path / "fit.json").read_text()
    for broken in ("", "{}", "[1]", text[: len(text) // 2], text.replace('"status"', '"state"')):
        (tmp_path / "fit.json").write_text(broken)
        with pytest.raises(ecfit.EcfitError):
            ecfit.Fit.load(tmp_path / "fit.json")


@pytest.mark.parametrize(("count", "nodes"), [(1024, 72), (300, 40), (128, 100)])
def test_a_thinned_axis_sums_polynomials_exactly(count: int, nodes: int):
    chosen, weights = thin(count, nodes)
    assert len(chosen) <= nodes + 2
    assert weights.min() > 0.0
    x = np.linspace(0.0, 1.0, count)
    for degree in (0, 1, 5, 12):
        assert weights @ x[chosen] ** degree == pytest.approx(np.sum(x**degree), rel=1e-10)


@pytest.mark.parametrize("degree", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_thinned_fit_is_as_good_as_one_of_all_rows(degree: int):
    table = synthetic(lambda x, y: np.sqrt(0.05 + x + y * y), 200, 200)
    thinned = ecfit.fit(table, ecfit.Rational(degree))
    few = synthetic(lambda x, y: np.sqrt(0.05 + x + y * y), 120, 120)
    assert Problem.of_table(few, thinned.terms).thinned(128).rows == few.values.size
    whole = ecfit.fit(few, ecfit.Rational(degree))
    assert thinned.rmse == pytest.approx(measure(whole.approximation, table).rmse, rel=2e-3)
