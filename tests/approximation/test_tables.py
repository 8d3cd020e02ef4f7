"""Bilinear tables as approximations, and the tables that a study asks for in their place."""

import numpy as np
import pytest

import ecfit
from ecfit.approximation.tables import lookup_name, lookup_request
from ecfit.coordinates import Axis
from ecfit.tables import Request


@pytest.fixture(scope="module")
def linear() -> ecfit.Approximation:
    """E = rho: what linear interpolation has exactly."""
    counts, ranges = {"rho": 3, "mu": 4}, {"rho": (0.1, 0.9)}
    return ecfit.lookup_table("lambertian", counts, through={"mu": "square"}, ranges=ranges)


def test_a_table_is_named_after_its_size_and_spacing(linear):
    assert linear.name == "table-3x4-mu-square"
    assert linear.form == "lookup"
    assert linear.count == 12
    assert linear.contract.model == "lambertian"
    assert linear.domain == ((0.1, 0.9), (0.0, 1.0))


def test_it_is_evaluated_like_any_other_and_holds_beyond_its_range(linear):
    rho, mu = np.array([0.1, 0.5, 0.9])[:, None], np.array([0.05, 0.3, 1.0])
    np.testing.assert_allclose(linear(rho=rho, mu=mu), np.broadcast_to(rho, (3, 3)), atol=1e-9)
    assert linear.at([np.array(2.0), np.array(0.5)]) == pytest.approx(0.9)


def test_a_map_or_range_of_no_coordinate_is_told():
    counts = {"rho": 2, "mu": 2}
    with pytest.raises(ecfit.EcfitError, match="unknown coordinate 'nu'"):
        ecfit.lookup_table("lambertian", counts, through={"nu": "square"})
    with pytest.raises(ecfit.EcfitError, match="unknown coordinate 'nu'"):
        ecfit.lookup_table("lambertian", counts, ranges={"nu": (0.0, 1.0)})


def test_a_map_that_does_not_exist_is_told():
    with pytest.raises(ecfit.EcfitError, match="unknown map 'cube'"):
        ecfit.lookup_table("lambertian", {"rho": 2, "mu": 2}, through={"mu": "cube"})


@pytest.fixture(scope="module")
def large() -> Request:
    axes = {"F0": Axis.spaced("F0", 40, 0.01, 0.25), "alpha": Axis.spaced("alpha", 50, 0.01, 0.81), "mu": 60}
    return Request.make("dielectric", axes, tolerance=1e-5)


def test_the_small_table_has_the_domain_of_the_large_one_in_its_own_view(large):
    counts = {"mu": 8, "r": 16, "F0": 4}
    small = lookup_request(large, counts, {"F0": "fourth-power"})
    assert lookup_name(small.grid) == "table-8x16x4-F0-fourth-power"
    assert small.grid.domain == (
        (0.0, 1.0),
        (pytest.approx(0.1), pytest.approx(0.9)),
        (pytest.approx(0.01), pytest.approx(0.25)),
    )
    np.testing.assert_allclose(np.diff(small.grid.axes[2].nodes ** 0.25, 2), 0.0, atol=1e-15)
    assert (small.contract, small.tolerance) == (large.contract, large.tolerance)
    assert small.key != large.key


@pytest.mark.parametrize(
    ("counts", "message"),
    [
        ({"r": 8, "mu": 8}, "cannot stand for a table of F0, alpha, mu"),
        ({"r": 8, "alpha": 8, "mu": 8}, "cannot stand for"),
        ({"F0": 8, "r": 8, "mu": 8, "k": 8}, "no axis stands for 'k': expected one of F0, alpha, mu"),
    ],
)
def test_other_coordinates_are_refused(large, counts, message):
    with pytest.raises(ecfit.EcfitError, match=message):
        lookup_request(large, counts, {})
