"""Published fits against the tables that they were made for (Sforza & Pellacini 2022)."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit.coordinates import Axis
from ecfit.metrics import measure

PREFIX = "sforza-pellacini-2022-"

# Mean absolute error on the authors' own 32^3 nodes, as recomputed with their coefficients.
MAE = {"glossy": 7.21e-3, "dielectric-entering": 4.209e-3, "dielectric-leaving": 5.03e-2}


def test_the_smallest_denominators_are_known():
    """The printed glossy fit has a pole in its domain, and the leaving one all but has."""
    glossy = ecfit.published(PREFIX + "glossy").smallest_denominator()
    assert glossy.value < 0.0
    assert glossy.bound <= 0.0
    leaving = ecfit.published(PREFIX + "dielectric-leaving").smallest_denominator()
    assert leaving.value == pytest.approx(9.6e-4, rel=1e-2)
    assert leaving.bound > 0.0
    assert ecfit.published(PREFIX + "dielectric-entering").smallest_denominator().bound > 0.0


@pytest.mark.parametrize("name", MAE)
def test_the_fits_of_three_variables_are_of_the_published_form(name):
    made = ecfit.published(PREFIX + name)
    assert made.variables == ("F0", "r", "mu")
    assert made.terms.count == ecfit.Rational(3).terms(3).count
    assert made.contract.sampling == "clamped"
    assert made.contract.transport == ("energy" if name == "glossy" else "radiance")


@cache
def table(name: str, count: int) -> ecfit.Table:
    """Clamped axes, seen as uniform on [0, 1], as the authors tabulated."""
    model, _, side = name.partition("-")
    dielectric = model == "dielectric"
    low, high = (0.0125, 0.25) if dielectric else (0.0, 1.0)
    axes = {
        "F0": Axis.spaced("F0", count, low, high),
        "r": Axis.spaced("r", count, 0.035, 1.0, "clamped"),
        "mu": Axis.spaced("mu", count, 0.02, 0.98 if dielectric else 1.0, "clamped"),
    }
    settings = {"side": side} if dielectric else {}
    transport = "radiance" if dielectric else "energy"
    return ecfit.tabulate(ecfit.model(model, **settings), axes, transport=transport, tolerance=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("name", MAE)
def test_the_mean_errors_are_those_of_the_published_coefficients(name):
    found = measure(ecfit.published(PREFIX + name), table(name, 32))
    assert found.mae == pytest.approx(MAE[name], rel=1e-2)


def test_a_published_fit_follows_its_table():
    """Few nodes: the order of the error, which a wrong view, side or transport would multiply."""
    name = "dielectric-entering"
    whole = table(name, 5)
    found = ecfit.published(PREFIX + name).on_grid([a.nominal for a in whole.axes])
    assert np.abs(found - whole.values).mean() < 3.0 * MAE[name]
