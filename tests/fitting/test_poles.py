"""Poles: found on the whole domain, said loudly, and never in a fit that calls itself converged."""

import dataclasses

import numpy as np
import pytest

import ecfit
from ecfit.contract import Contract
from ecfit.fitting import STATUSES, Fit
from ecfit.forms import Terms

POLE = 0.37


@pytest.fixture(scope="module")
def poled(make_table, unit_axis) -> Fit:
    """1 / (r - 0.37)^2, which is a rational function of degree 2 with a pole between two of 32 nodes."""
    axis = unit_axis("r", 32)
    assert np.abs(axis.nodes - POLE).min() > 0.01
    return ecfit.fit(
        make_table(lambda x: 1.0 / (x - POLE) ** 2, axis), ecfit.Rational(2, guarded=False), name="poled"
    )


def test_a_pole_between_nodes_is_reported(poled):
    """The fit is perfect on the nodes: only the denominator's minimum over the domain shows it."""
    assert poled.rmse < 1e-6
    assert poled.status == "pole"
    assert not poled.ok
    assert poled.smallest.bound <= 0.0
    assert poled.smallest.place[0] == pytest.approx(POLE, abs=1e-3)


def test_the_warning_names_the_fit_the_place_and_a_remedy(poled):
    warning = poled.warning()
    assert "HAS A POLE" in warning
    for part in ("poled", "r = 0.37", "do not use it", "another degree"):
        assert part in warning


def test_a_poled_fit_can_be_saved_and_is_still_poled(poled, tmp_path):
    poled.save(tmp_path / "fit.json")
    assert Fit.load(tmp_path / "fit.json").status == "pole"


def test_infinite_errors_and_predictions_survive_the_file(poled, tmp_path):
    """A node or a grid point may fall on a pole exactly."""
    errors = dataclasses.replace(poled.errors, rmse=np.inf, max_error=np.inf, mae=np.inf)
    dataclasses.replace(poled, errors=errors, prediction=(-np.inf, np.inf)).save(tmp_path / "fit.json")
    again = Fit.load(tmp_path / "fit.json")
    assert again.rmse == np.inf
    assert again.prediction == (-np.inf, np.inf)


def test_a_fit_that_calls_itself_converged_has_no_pole(make_table, unit_axis):
    """Data with poles of both signs tempt the descent; what it returns is judged on fine grids here."""
    table = make_table(lambda x, y: 1.0 / (x - POLE) + y, unit_axis("r", 20), unit_axis("mu", 16))
    fit = ecfit.fit(table, ecfit.Rational(1))
    fine = np.linspace(0.0, 1.0, 500)
    q = np.asarray(fit.approximation.denominator(r=fine[:, None], mu=fine))
    if fit.status == "converged":
        assert q.min() > 0.0
    else:
        assert fit.warning()
    assert fit.smallest.bound <= q.min() + 1e-9
    assert fit.rmse > 0.1  # no pole-free rational function is near


def test_an_approximation_finds_the_pole_of_its_denominator():
    # Q = 1 - 2 x y vanishes on a curve that misses every corner.
    terms = Terms(np.array([[0, 0]]), np.array([[1, 1]]))
    made = ecfit.Approximation.quotient(
        "x",
        "rational",
        "0/2",
        ("r", "mu"),
        terms,
        np.array([1.0, -2.0]),
        ((0.0, 1.0),) * 2,
        Contract("unknown"),
    )
    least = made.smallest_denominator()
    assert least.value == pytest.approx(-1.0, abs=1e-9)
    assert least.place == (1.0, 1.0)
    inside = dataclasses.replace(made, domain=((0.0, 0.6), (0.0, 0.6)))
    assert inside.smallest_denominator().bound == pytest.approx(1.0 - 2 * 0.36, abs=1e-9)


def test_every_status_has_words(poled):
    assert poled.status in STATUSES
    assert set(STATUSES) == {"converged", "not-converged", "pole"}


def test_a_pole_between_the_guards_is_watched(make_table, unit_axis):
    """A pole narrower than the guards' spacing tempts the descent: it comes back without one."""
    # Q = (x - 0.513)^2 - 1e-6 is negative for 0.002 only, within a cell of 1/40.
    table = make_table(lambda x: 1.0 / ((x - 0.513) ** 2 - 1e-6) * 1e-3, unit_axis("r", 32))
    free = ecfit.fit(table, ecfit.Rational(2, guarded=False), max_steps=50)
    held = ecfit.fit(table, ecfit.Rational(2), max_steps=50)
    assert free.status == "pole"
    assert free.rmse < held.rmse
    assert held.status != "pole"
    assert held.smallest.bound > 0.0


@pytest.mark.slow
def test_an_unguarded_fit_without_a_pole_is_the_guarded_one(make_table, unit_axis):
    table = make_table(lambda x: np.sqrt(0.1 + x), unit_axis("r", 24))
    free, held = (ecfit.fit(table, ecfit.Rational(2, guarded=g)) for g in (False, True))
    assert (free.status, held.status) == ("converged", "converged")
    assert free.rmse == pytest.approx(held.rmse, rel=1e-4)
    assert free.approximation.form == "rational-unguarded"
