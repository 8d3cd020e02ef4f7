"""Structured forms as configs and users write them."""

import numpy as np
import pytest

import ecfit
from ecfit.errors import EcfitError
from ecfit.forms import form, forms
from ecfit.forms.candidates import Powers

GIVEN = {
    "head": "corner",
    "features": ["alpha", "mu"],
    "numerators": [[[1, 0], [0, 1]]],
    "denominator": [[3, 0], [0, 3], [1.5, 1.5]],
}
WITHIN = {
    "head": "corner",
    "features": ["alpha", "mu"],
    "numerators": [{"highest": {"alpha": 2, "mu": 2}, "lowest_order": 1.0}],
    "denominator": {"highest": {"alpha": 3, "mu": 3}, "lowest_order": 3.0},
    "budget": 4,
}


def test_names_and_counts():
    made = form("structured", **GIVEN, start=[1, 2, 3, 4])
    assert isinstance(made, ecfit.Structured)
    assert (made.name, made.degree, made.count(2)) == ("corner", "4", 4)
    assert made.start == (1.0, 2.0, 3.0, 4.0)
    chosen = form("selected", **WITHIN)
    assert isinstance(chosen, ecfit.Selected)
    assert (chosen.name, chosen.degree, chosen.count(2)) == ("corner-selected", "4", 4)
    assert not made.linear
    assert set(forms()) >= {"polynomial", "rational", "structured", "selected"}


def test_bounds_may_be_powers_or_their_fields():
    made = ecfit.Selected(**{**WITHIN, "denominator": Powers({"alpha": 3, "mu": 3}, lowest_order=3.0)})
    np.testing.assert_array_equal(made.whole.denominator, ecfit.Selected(**WITHIN).whole.denominator)


def test_a_head_may_be_its_fields():
    head = {"name": "mine", "factors": [{"alpha": 2}], "text": "1 - X", "deficit": "X"}
    made = ecfit.Structured(**{**GIVEN, "head": head})
    assert made.name == "mine"
    assert made.structure.head.symbols == ("X",)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("structured", {"head": "crner"}, "unknown head 'crner'.*did you mean 'corner'"),
        ("structured", {"head": None}, "a head is a name or a table"),
        ("structured", {"features": ["aplha", "mu"]}, "unknown feature 'aplha'.*did you mean 'alpha'"),
        ("structured", {"features": "alpha"}, "unknown feature 'a'"),
        ("structured", {"numerators": [[[1, 0], [1]]]}, "numerator: exponents must be rows of 2 numbers"),
        ("structured", {"numerators": [[1, 0], [0, 1]]}, "needs 1 numerators, got 2"),
        ("structured", {"numerators": [[[1, 0, 0]]]}, "rows of 2 numbers"),
        ("structured", {"denominator": [[3]]}, "denominator: exponents must be rows of 2 numbers"),
        ("structured", {"denominator": [[3, -1]]}, "must be in 0..64"),
        ("structured", {"start": [1.0]}, "start needs 4 coefficients, got 1"),
        ("structured", {"start": [1.0, 2.0, float("nan"), 4.0]}, "start must be finite"),
        ("structured", {"strat": [1.0]}, "'structured' does not take strat.*did you mean 'start'"),
        ("structured", {"features": None}, "form 'structured'"),
        ("selected", {"budget": 1}, "budget must be an integer >= 2, got 1"),
        ("selected", {"budget": 4.0}, "budget must be an integer"),
        ("selected", {"budget": 400}, r"the budget is 400, but there are only \d+ candidate terms"),
        ("selected", {"rounds": -1}, "rounds must be an integer >= 0"),
        ("selected", {"seeds": True}, "seeds must be an integer >= 1, got True"),
        ("selected", {"denominator": {"highest": {"mu": 0}}}, "leave one term"),
        ("selected", {"denominator": {"hihgest": {"mu": 3}}}, "bounds of terms take highest, .*got hihgest"),
        ("selected", {"denominator": 3}, "bounds of terms must be a table"),
        ("selected", {"numerators": [{"highest": {"muu": 3}}]}, "highest names 'muu'"),
        ("selected", {"numerators": []}, "needs 1 numerators, got 0"),
        ("selected", {"numerators": WITHIN["numerators"] * 3}, "needs 1 numerators, got 3"),
    ],
)  # fmt: skip
def test_what_makes_no_form_is_told(name: str, change: dict, words: str):
    good = GIVEN if name == "structured" else WITHIN
    with pytest.raises(EcfitError, match=words) as caught:
        form(name, **{**good, **change})
    assert "\n" not in str(caught.value)


def test_three_ratios_need_a_budget_for_a_term_each():
    bounds = {"highest": {"alpha": 2, "mu": 2}}
    with pytest.raises(EcfitError, match="head 'two-point' needs a budget of at least 4"):
        ecfit.Selected("two-point", ("alpha", "mu"), [bounds] * 3, bounds, budget=3)
    assert ecfit.Selected("two-point", ("alpha", "mu"), [bounds] * 3, bounds, budget=4).budget == 4
