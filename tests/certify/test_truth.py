"""Samples are what their rule says, repeatable, and within the domain."""

from collections.abc import Callable

import numpy as np
import pytest

import ecfit
from ecfit.approximation import Approximation
from ecfit.certify.narrow import drift, hard_points
from ecfit.certify.truth import Sampling, corner_points
from ecfit.errors import EcfitError
from ecfit.expressions import parse

Make = Callable[..., Approximation]


def test_uniform_in_r_mu_and_the_root_of_f0(two_point: Make):
    points = Sampling(20_000, 3).points(two_point())
    r, s = np.sqrt(points["alpha"]), np.sqrt(points["F0"])
    for values, low, high in ((r, 0.03, 1.0), (points["mu"], 0.02, 1.0), (s, 0.1, 0.9**0.5)):
        assert low <= values.min() < low + 0.01
        assert high - 0.01 < values.max() <= high + 1e-12
        assert values.mean() == pytest.approx(0.5 * (low + high), abs=0.01)
    again = Sampling(20_000, 3).points(two_point())
    assert all(np.array_equal(points[n], again[n]) for n in points)
    assert not np.array_equal(points["mu"], Sampling(20_000, 4).points(two_point())["mu"])


def test_the_index_of_refraction_is_sampled_by_its_reflectance():
    points = Sampling(500).points(ecfit.published("deon-average-fresnel"))
    assert points["ior"].min() >= 1.0
    assert points["ior"].max() <= 3.0


def test_a_range_outside_the_domain_is_refused(written: Make):
    with pytest.raises(EcfitError, match="outside the domain"):
        Sampling(5, ranges={"mu": (2.0, 3.0)}).points(written("mu"))
    with pytest.raises(EcfitError, match="1 point or more"):
        Sampling(0)


def test_towards_the_corner(corner: Make, written: Make):
    points = corner_points(corner(), 200, 1)
    r = np.sqrt(points["alpha"])
    assert np.all((r <= 0.03) | (points["mu"] <= 0.02))
    assert r.min() < 2e-3
    assert points["mu"].min() < 2e-4
    assert corner_points(written("F0", ("F0",)), 10, 1) == {}


def test_hard_points_include_the_ends(corner: Make):
    points = hard_points(corner(), 400, 0)
    for values in points.values():
        assert values.min() == 0.0
        assert values.max() == 1.0


def test_drift_counts_what_is_not_finite():
    node = parse("x*x*x/(x*x*x)", ("x",))
    found = drift(node, {"x": np.array([1.0, 0.5, 1e-4])}, "float16")
    assert found.not_finite == 1
    assert found.largest == 0.0
    assert found.not_finite_place["x"] == pytest.approx(1e-4, rel=1e-2)
    assert "1 of 3 not finite" in found.describe()
    none = drift(parse("1/(x - x)", ("x",)), {"x": np.ones(2)}, "float32")
    assert none.not_finite == 2
    assert "no finite value" in none.describe()
