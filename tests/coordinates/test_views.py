"""Views: r for alpha, F0 for ior, each the other's inverse."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.coordinates import VIEWS, resolve, view_of, viewed
from ecfit.errors import EcfitError

UNIT = st.floats(1e-3, 0.999)


@given(r=UNIT)
def test_r_and_alpha_are_the_same_roughness(r):
    assert resolve(["alpha"], {"r": r})["alpha"] == pytest.approx(r * r, rel=1e-15)
    assert resolve(["r"], {"alpha": r})["r"] == pytest.approx(r**0.5, rel=1e-15)


@pytest.mark.parametrize("name", VIEWS)
@given(x=UNIT)
def test_a_coordinate_survives_the_way_to_the_parameter_and_back(name, x):
    of = VIEWS[name].of
    there = resolve([of], {name: x})[of]
    assert resolve([name], {of: there})[name] == pytest.approx(x, rel=1e-12)


def test_a_coordinate_is_seen_in_its_own_axis_and_no_other():
    assert viewed("mu", "mu", 0.3) == 0.3
    assert viewed("r", "alpha", 0.25) == 0.5
    assert viewed("ior", "F0", 0.04) == pytest.approx(1.5)
    assert viewed("r", "mu", 0.25) is None
    assert viewed("F0", "rho", 0.25) is None


def test_coordinates_pass_through_in_the_order_asked_for():
    assert list(resolve(["r", "mu"], {"mu": 1.0, "alpha": 0.25}).items()) == [("r", 0.5), ("mu", 1.0)]


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"r": 0.5}, "'mu' is missing: expected r, mu"),
        ({"r": 0.5, "alpha": 0.25, "mu": 1.0}, "'r' given more than once: as r and alpha"),
        ({"r": 0.5, "mu": 1.0, "F0": 0.04}, "'F0' is not used here"),
        ({"roughness": 0.5, "mu": 1.0}, "'r' is missing"),
    ],
)
def test_missing_repeated_and_foreign_coordinates_are_refused(given_, message):
    with pytest.raises(EcfitError, match=message):
        resolve(["r", "mu"], given_)


def test_a_models_own_parameter_wins_over_a_view():
    assert view_of("F0", ["F0", "ior"])[0] == "F0"
    assert view_of("F0", ["ior"])[0] == "ior"


def test_an_unknown_coordinate_lists_parameters_and_views():
    with pytest.raises(EcfitError, match=r"expected one of alpha, mu, r; did you mean 'alpha'"):
        view_of("alhpa", ["alpha", "mu"])
