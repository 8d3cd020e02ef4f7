"""Proofs of signs and ranges: granted where they hold, also where a factor touches 0."""

from collections.abc import Callable

import numpy as np
import pytest

from ecfit.approximation import Approximation
from ecfit.certify.proofs import SLACK, Ceiling, divisors, nonnegative, value_range
from ecfit.certify.subject import Subject
from ecfit.expressions import const, parse, value

Make = Callable[..., Approximation]
ONE = Ceiling("1", const(1.0))


def test_a_shared_factor_that_touches_zero_is_divided_out(written: Make):
    subject = Subject.of(written("mu"))
    for text in (
        "mu*(2 - r) - mu*r",
        "mu*mu*r + 3*mu",
        "(1 - mu)**5 - (1 - mu)**5*0.5*r",
        "mu/(1 + r) - mu/(1 + 2*r)",
    ):
        assert nonnegative(parse(text, ("r", "mu")), subject), text
    for text in ("mu - r", "mu*(r - 0.5) + 0*mu", "-mu"):
        assert not nonnegative(parse(text, ("r", "mu")), subject), text


def test_divisors_keep_the_sign_of_the_centre(written: Make):
    (proof,) = divisors(Subject.of(written("1/(mu - 1.5)")))
    assert proof.proven
    assert proof.claim == "-divisor 1 > 0"
    assert proof.bound == pytest.approx(0.5, rel=1e-2)


def test_the_range_contains_all_values(corner: Make):
    rng = np.random.default_rng(4)
    points = [rng.uniform(low, high, 20_000) for low, high in corner().domain]
    found = corner().formula.value(points)
    proved = value_range(Subject.of(corner()), ONE, 1)
    assert proved.low - 1e-12 <= found.min()
    assert found.max() <= proved.high + 1e-12
    assert proved.proven


def test_a_form_that_exceeds_one_is_told_where(corner: Make):
    # A negative numerator near the corner: E > 1 there.
    approximation = corner(
        [-0.05, 0.11125, 0.89389, 0.55689, -0.57248, 0.20031, 0.17076, 0.32043, 0.36454, -0.05526]
    )
    found = value_range(Subject.of(approximation), ONE, 1)
    assert not found.proven
    assert found.excess > 0.04
    (fault,) = found.faults
    assert "exceed 1" in fault
    place = found.excess_place
    # In the chart: the place may lie nearer to the corner than the cosine that evaluation raises to.
    rho = np.float64(place["alpha"] + place["mu"])
    here = value(Subject.of(approximation).value, {"t": place["alpha"] / rho, "rho": rho})
    assert float(here) == pytest.approx(found.greatest, abs=1e-6)


def test_without_a_ceiling_finite_values_suffice(written: Make):
    found = value_range(Subject.of(written("3*r + mu")), None, 1)
    assert found.proven
    assert found.high >= 4.0
    assert not found.faults
    assert not value_range(Subject.of(written("r - 0.5")), None, 1).proven


def test_rounding_beyond_one_is_tolerated_and_no_more(written: Make):
    near = value_range(Subject.of(written("mu + 1e-12")), ONE, 1)
    assert near.proven
    assert "2^-24" in " ".join(near.describe())
    assert not value_range(Subject.of(written(f"mu + {4.0 * SLACK!r}")), ONE, 1).proven


def test_the_chart_and_the_formula_are_the_same_function(corner: Make, two_point: Make):
    rng = np.random.default_rng(0)
    for approximation in (corner(), two_point()):
        subject = Subject.of(approximation)
        points = {
            n: rng.uniform(max(low, 1e-3), high, 500) for n, (low, high) in subject.domain.ranges.items()
        }
        rho = points["alpha"] + points["mu"]
        chart = {**points, "rho": rho, "t": points["alpha"] / rho}
        plain = approximation.formula.value([points[n] for n in approximation.variables])
        assert np.allclose(value(subject.value, chart), plain, rtol=0.0, atol=1e-12)
