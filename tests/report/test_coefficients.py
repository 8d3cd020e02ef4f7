"""Published coefficients beside recomputed ones: in the same monomials, or not at all."""

import dataclasses

import numpy as np
import pytest

import ecfit
from ecfit.contract import Contract
from ecfit.forms import Terms
from ecfit.report.coefficients import compare

# 1 / (1 + t) in t = (x - 0.5) / 2, as printed.
PUBLISHED = ecfit.Approximation.quotient(
    "printed", "rational", "1", ("r",), Terms(np.array([[0], [1]]), np.array([[1]])),
    np.array([1.0, 0.0, 1.0]), ((0.0, 1.0),), Contract("unknown"), scales=((0.5, 2.0),),
)  # fmt: skip


@pytest.fixture(scope="module")
def fits(make_table, unit_axis) -> list[ecfit.Fit]:
    """The same function recomputed, and a form of other monomials."""
    table = make_table(lambda x: 1.0 / (1.0 + 0.5 * (x - 0.5)), unit_axis("r", 12))
    return [ecfit.fit(table, form) for form in (ecfit.Rational(1), ecfit.Polynomial(2))]


def test_only_a_fit_of_the_same_monomials_is_compared(fits):
    (found,) = compare(PUBLISHED, fits)
    assert (found.published, found.fit) == ("printed", "rational 1")
    assert compare(dataclasses.replace(PUBLISHED, variables=("mu",)), fits) == []


def test_recomputed_coefficients_are_in_the_published_scales(fits):
    (found,) = compare(PUBLISHED, fits)
    assert [row[:2] for row in found.rows] == [("numerator", "1"), ("numerator", "r"), ("denominator", "r")]
    np.testing.assert_allclose([row[2] for row in found.rows], PUBLISHED.coefficients)
    np.testing.assert_allclose([row[3] for row in found.rows], PUBLISHED.coefficients, atol=1e-5)


def test_scales_are_told_where_they_are_not_plain(fits):
    (found,) = compare(PUBLISHED, fits)
    assert found.note == "r stands for (r - 0.5) / 2"
    plain = PUBLISHED.with_quotient(scales=((0.0, 1.0),))
    assert compare(plain, fits)[0].note == ""


def test_a_fit_with_a_pole_at_the_published_origin_is_left_out(fits):
    """Its denominator has no constant 1 there."""
    poled = fits[0].approximation.with_quotient(values=np.array([1.0, 0.0, -2.0]))
    assert compare(PUBLISHED, [dataclasses.replace(fits[0], approximation=poled)]) == []


def test_monomials_are_written_as_they_are_printed(fits):
    terms = ecfit.Rational(2).terms(2)
    made = ecfit.Approximation.quotient(
        "p", "rational", "2", ("r", "mu"), terms, np.arange(1.0, 12.0), ((0.0, 1.0),) * 2, Contract("unknown")
    )
    (found,) = compare(made, [dataclasses.replace(fits[0], approximation=made)])
    assert [row[1] for row in found.rows[:6]] == ["1", "r", "mu", "r^2", "r mu", "mu^2"]
    assert [row[2] for row in found.rows] == [row[3] for row in found.rows]
