"""Metrics against their definitions, by hand."""

import json

import numpy as np
import pytest

import ecfit
from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.forms import Terms
from ecfit.metrics import Errors, measure, predict, prediction_range, signed_error


def approximation(numerator, denominator=(), variables=("r", "mu"), domain=None) -> ecfit.Approximation:
    """From {exponents: coefficient} of numerator and denominator."""
    p, q = dict(numerator), dict(denominator)
    terms = Terms(np.array(list(p)), np.array(list(q), dtype=int).reshape(-1, len(variables)))
    coefficients = np.array([*p.values(), *q.values()])
    domain = domain or ((0.0, 1.0),) * len(variables)
    return ecfit.Approximation.quotient(
        "x", "rational", "1", variables, terms, coefficients, domain, Contract("unknown")
    )


SUM = approximation({(1, 0): 1.0, (0, 1): 10.0})  # r + 10 mu
R, MU = Axis.given("r", [0.0, 0.5, 1.0]), Axis.given("mu", [0.2, 0.4])


def test_errors_are_those_of_their_definitions(make_table):
    table = make_table(lambda r, mu: r + 10 * mu + np.where((r == 0.5) & (mu == 0.4), 0.3, 0.1), R, MU)
    errors = measure(SUM, table)
    assert errors.mae == pytest.approx((5 * 0.1 + 0.3) / 6)
    assert errors.rmse == pytest.approx(np.sqrt((5 * 0.01 + 0.09) / 6))
    assert errors.max_error == pytest.approx(0.3)
    assert errors.place == {"r": 0.5, "mu": 0.4}
    deviations = np.abs(table.values / (table.values - np.where(table.values == 4.8, 0.3, 0.1)) - 1.0)
    assert errors.furnace_mean == pytest.approx(deviations.mean())
    assert errors.furnace_max == pytest.approx(deviations.max())


def test_signed_errors_are_approximation_minus_table(make_table):
    table = make_table(lambda r, mu: r + 10 * mu + 0.25, R, MU)
    np.testing.assert_allclose(signed_error(SUM, table), -0.25)


def test_variables_go_by_name_not_by_place(make_table):
    table = make_table(lambda mu, r: r + 10 * mu, MU, R)
    assert predict(SUM, table).shape == (2, 3)
    assert measure(SUM, table).max_error < 1e-15


def test_clamped_axes_are_judged_at_their_nominal_coordinates(make_table):
    clamped = Axis.spaced("r", 5, 0.3, 0.8, "clamped")
    table = make_table(lambda r, mu: r + 10 * mu, clamped, MU)  # of nominal coordinates
    assert measure(SUM, table).max_error < 1e-15


def test_entries_that_are_not_finite_are_left_out(make_table):
    table = make_table(lambda r, mu: np.where(r == 1.0, np.nan, r + 10 * mu + 0.1), R, MU)
    errors = measure(SUM, table)
    assert errors.mae == pytest.approx(0.1)
    assert errors.place["r"] < 1.0


def test_a_table_of_nan_cannot_be_judged(make_table):
    with pytest.raises(EcfitError, match="no finite entry"):
        measure(SUM, make_table(lambda r, mu: np.nan * r * mu, R, MU))


def test_a_furnace_is_infinitely_wrong_where_the_normaliser_is_not_positive(make_table):
    table = make_table(lambda r, mu: 1.0 + 0 * r, R, MU)
    shifted = approximation({(0, 0): -0.5, (1, 0): 1.0})  # r - 1/2: negative, zero and positive
    errors = measure(shifted, table)
    assert errors.furnace_max == np.inf
    assert errors.max_error == 1.5


def test_another_functions_table_is_refused(make_table):
    table = make_table(lambda ior, mu: ior + mu, Axis.given("ior", [1.1, 1.2]), MU)
    with pytest.raises(EcfitError, match="function of r, mu, the table of ior, mu"):
        measure(SUM, table)


def test_long_tables_have_no_seams(make_table):
    r, mu = Axis.spaced("r", 300), Axis.spaced("mu", 250)  # 75 000 entries: three blocks
    table = make_table(lambda r, mu: r + 10 * mu, r, mu)
    np.testing.assert_allclose(predict(SUM, table), table.values, atol=1e-14)


def test_errors_survive_json_with_infinities():
    errors = Errors(0.1, 0.2, np.inf, {"r": 0.5}, 0.3, np.inf)
    text = json.dumps({k: None if v == np.inf else v for k, v in errors.to_dict().items()})
    assert Errors.from_dict(json.loads(text)) == errors


@pytest.mark.parametrize("change", [{"mae": "x"}, {"place": 3}, {"place": {"r": "x"}}, {"rmse": []}])
def test_malformed_errors_are_refused(change):
    data = Errors(0.1, 0.2, 0.3, {"r": 0.5}, 0.3, 0.4).to_dict()
    with pytest.raises(EcfitError, match="malformed errors"):
        Errors.from_dict({**data, **change})
    with pytest.raises(EcfitError, match="malformed errors"):
        Errors.from_dict({k: v for k, v in data.items() if k != "mae"})


def test_the_range_of_predictions_looks_between_the_nodes(make_table):
    """4 r (1 - r) is 0 on both nodes and 1 between them."""
    bump = approximation({(1,): 4.0, (2,): -4.0}, variables=("r",))
    table = make_table(lambda r: 0.0 * r, Axis.given("r", [0.0, 1.0]))
    assert prediction_range(bump, table) == pytest.approx((0.0, 1.0))


def test_the_published_fit_is_judged_as_in_the_documents(paper_table):
    """Figures that our reports quote of the printed coefficients; a change is a change of the numerics."""
    errors = measure(ecfit.published("sforza-pellacini-2022-conductor"), paper_table)
    assert errors.rmse == pytest.approx(5.64866e-3, abs=1e-8)
    assert errors.mae == pytest.approx(4.1012e-3, abs=1e-7)
    assert errors.max_error == pytest.approx(0.026778, abs=1e-6)
    assert errors.place == {"r": 0.0, "mu": 0.0}
    assert errors.furnace_max == pytest.approx(0.081917, abs=1e-6)


def test_one_wrong_coefficient_shows(paper_table):
    """The metric is sensitive: a change of 2e-4 in one of 19 coefficients moves the error."""
    right = ecfit.published("sforza-pellacini-2022-conductor")
    wrong = right.with_quotient(values=right.coefficients + 0.01 * (np.arange(19) == 4))
    assert measure(wrong, paper_table).rmse > 1.001 * measure(right, paper_table).rmse
