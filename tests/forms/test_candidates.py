"""Candidate terms: all that the bounds allow and no others, each once."""

import itertools

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.forms import head
from ecfit.forms.candidates import Powers, candidates, chosen

FEATURES = ("alpha", "mu", "r")
BOUNDS = Powers({"alpha": 2, "mu": 1.5, "r": 2}, 0.5, 1.0, 3.0, 2, 3.0)


def whole():
    return candidates(head("corner"), FEATURES, [BOUNDS], BOUNDS)


def test_rows_are_those_that_the_bounds_allow():
    """Against a plain loop over quarters: r is no feature of order 1, so its exponents are whole."""
    expected = set()
    for a, m, r in itertools.product(
        np.arange(0, 2.01, 0.25), np.arange(0, 1.51, 0.25), np.arange(0, 2.01, 0.25)
    ):
        fits = a % 0.5 == 0 and m % 0.5 == 0 and r % 1 == 0
        order = a + m + 0.5 * r
        if fits and 1.0 <= order <= 3.0 and int(a > 0) + int(m > 0) + int(r > 0) <= 2 and a + m + r <= 3.0:
            expected.add((a, m, r))
    rows = BOUNDS.rows(FEATURES)
    assert {tuple(r) for r in rows.tolist()} == expected
    assert len(rows) == len(expected)
    orders = rows @ [1.0, 1.0, 0.5]
    assert np.all(np.diff(orders) >= 0.0)


def test_features_without_a_bound_are_not_used():
    assert Powers({"mu": 2}).rows(("alpha", "mu")).tolist() == [[0, 0], [0, 1], [0, 2]]


def test_the_chosen_are_the_terms_asked_for():
    rows = BOUNDS.rows(FEATURES)
    made = chosen(whole(), [[3, 0], [5, 2]], 7)
    index = [FEATURES.index(f) for f in made.features]
    np.testing.assert_array_equal(made.numerators[0], rows[[3, 0]][:, index])
    np.testing.assert_array_equal(made.denominator, rows[[7, 5, 2]][:, index])


def test_a_choice_that_outgrows_its_factor_is_refused():
    """Without a term of low order in Q, P / Q is larger than the factor of the head can mend."""
    bounds = Powers({"mu": 4}, lowest_order=1.0)
    steep = candidates(head("ratio"), ("mu",), [bounds], bounds)
    with pytest.raises(EcfitError, match="outgrows its factor"):
        chosen(steep, [[0], [2]], 1)
    assert chosen(steep, [[1], [2]], 1).count == 2


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        (Powers({"mou": 3}), "highest names 'mou', which is not among the features alpha, mu, r"),
        (Powers({"mu": -1}), "highest exponent of mu must be in 0..64"),
        (Powers({"mu": 3}, total=[0, 3]), r"total must be a number, got \[0, 3\]"),
        (Powers({"mu": 3}, lowest_order="1"), "lowest_order must be a number, got '1'"),
        (Powers({"mu": "3"}), "highest exponent of mu must be in 0..64, got '3'"),
        (Powers({"mu": float("inf")}), "0..64"),
        (Powers({"mu": 3}, step=0.0), "step must be in 0.25..64, got 0.0"),
        (Powers({"mu": 3}, step=float("nan")), "step must be in"),
        (Powers({"mu": 3}, lowest_order=5.0), "0 candidate terms within the bounds"),
        (Powers({"alpha": 64, "mu": 64}, step=0.25), "33153 candidate terms within the bounds"),
        (Powers({"alpha": 64, "mu": 64, "r": 64}, step=0.25), "candidate terms: lower the exponents"),
    ],
)  # fmt: skip
def test_bounds_without_sense_are_told(bounds: Powers, words: str):
    with pytest.raises(EcfitError, match=words):
        bounds.rows(FEATURES)


def test_astronomic_numbers_of_candidates_are_told_at_once(no_hang):
    from ecfit.forms.features import FEATURES as every

    names = tuple(every)
    with pytest.raises(EcfitError, match="lower the exponents"):
        Powers(dict.fromkeys(names, 63.0)).rows(names)
