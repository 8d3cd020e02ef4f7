"""Families of forms: what their degrees mean, and how one leads to the next."""

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.forms import MAX_DEGREE, Form, Polynomial, Rational, form, forms


@pytest.mark.parametrize(
    ("variables", "degree", "count"), [(1, 3, 4), (2, 1, 3), (2, 3, 10), (3, 3, 20), (2, 20, 231)]
)
def test_a_polynomial_has_the_binomial_number_of_terms(variables, degree, count):
    terms = Polynomial(degree).terms(variables)
    assert terms.count == count
    assert len(terms.denominator) == 0
    assert Polynomial(degree).linear


def test_a_rational_has_two_polynomials_with_one_constant_implied():
    terms = Rational(3).terms(2)
    np.testing.assert_array_equal(terms.denominator, terms.numerator[1:])
    apart = Rational(numerator=4, denominator=2).terms(2)
    assert (len(apart.numerator), len(apart.denominator)) == (15, 5)
    assert not Rational(3).linear


def test_a_rational_without_denominator_is_a_polynomial():
    flat = Rational(numerator=3, denominator=0)
    assert flat.linear
    np.testing.assert_array_equal(flat.terms(2).numerator, Polynomial(3).terms(2).numerator)
    assert flat.terms(2).count == Polynomial(3).terms(2).count


@pytest.mark.parametrize(
    ("made", "name", "degree"),
    [
        (lambda: Polynomial(4), "polynomial", "4"),
        (lambda: Rational(4), "rational", "4"),
        (lambda: Rational(numerator=4, denominator=4), "rational", "4"),
        (lambda: Rational(numerator=4, denominator=2), "rational", "4/2"),
        (lambda: Polynomial(np.int64(4)), "polynomial", "4"),  # pyright: ignore[reportArgumentType]
    ],
)
def test_forms_name_themselves(made, name, degree):
    assert (made().name, made().degree) == (name, degree)


def test_coarser_forms_end_before_a_constant():
    names = []
    current: Form | None = Rational(numerator=3, denominator=1)
    while current is not None:
        names.append(current.degree)
        current = current.coarser()
    assert names == ["3/1", "2/0", "1/0"]
    assert Polynomial(3).coarser() is None


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"numerator": 3},
        {"denominator": 3},
        {"numerator": 0, "denominator": 0},
        {"numerator": -1, "denominator": 2},
        {"numerator": MAX_DEGREE + 1, "denominator": 2},
        {"numerator": 2, "denominator": 2.0},
        {"degree": 3, "denominator": 2},
    ],
)
def test_degrees_without_meaning_are_refused(settings):
    with pytest.raises(EcfitError):
        Rational(**settings)


def test_every_named_form_can_be_made():
    terms = {"numerators": [[[1, 0]]], "denominator": [[3, 0], [0, 3]]}
    powers = {"highest": {"alpha": 2, "mu": 2}, "lowest_order": 1}
    within = {"numerators": [powers], "denominator": {**powers, "lowest_order": 3}, "budget": 3}
    features = {"head": "corner", "features": ["alpha", "mu"]}
    settings = {
        "polynomial": {"degree": 2},
        "rational": {"degree": 2},
        "structured": {**features, **terms},
        "selected": {**features, **within},
        "module": {"module": "learned-rational", "settings": {"degree": 1}},
        "composed": {"text": "E1*S", "parts": {"E1": "conductor-10", "S": "glossy-15"}},
    }
    assert settings.keys() == forms().keys()
    names = {name: form(name, **given).name for name, given in settings.items()}
    assert names == {
        "polynomial": "polynomial", "rational": "rational",
        "structured": "corner", "selected": "corner-selected", "module": "learned-rational",
        "composed": "composed",
    }  # fmt: skip


@pytest.mark.parametrize(("name", "settings"), [("splines", {"degree": 3}), ("rational", {"order": 3})])
def test_unknown_forms_and_settings_are_refused(name, settings):
    with pytest.raises(EcfitError, match=r"splines|order"):
        form(name, **settings)
