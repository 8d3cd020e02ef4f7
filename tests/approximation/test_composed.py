"""Formulas of formulas: values compose, parts may have fewer variables, nonsense is refused."""

import json

import numpy as np
import pytest

from ecfit.approximation import Written
from ecfit.approximation.composed import Composed, Part
from ecfit.errors import EcfitError

E1 = Written(("mu", "alpha"), "1 - 0.3 * alpha / (mu + 0.25)")
AVERAGE = Written(("alpha",), "1 - 0.25 * alpha**2")
PARTS = (Part("E", ("mu", "alpha"), E1), Part("A", ("alpha",), AVERAGE))
WHOLE = Composed(("alpha", "mu"), "(1 - E) * A", PARTS)


def test_the_value_is_that_of_the_parts():
    alpha, mu = np.linspace(0.0, 1.0, 5)[:, None], np.linspace(0.0, 1.0, 4)
    e, a = E1.value([mu, alpha]), AVERAGE.value([alpha])
    np.testing.assert_allclose(WHOLE.value([alpha, mu]), (1.0 - e) * a, rtol=1e-14)
    assert WHOLE.variables == 2
    assert WHOLE.count == E1.coefficients.size + AVERAGE.coefficients.size


def test_the_least_denominator_is_that_of_a_part_at_its_place():
    found = WHOLE.smallest_denominator(((0.0, 1.0), (0.0, 1.0)))
    assert found.value == pytest.approx(0.25, abs=1e-3)
    assert len(found.place) == 2
    assert found.place[1] == pytest.approx(0.0, abs=1e-2)


def test_it_reads_back():
    data = {**json.loads(json.dumps(WHOLE.to_dict())), "variables": ["alpha", "mu"]}
    again = Composed.from_dict(data, 2)
    assert again.to_dict() == WHOLE.to_dict()
    at = [np.array([0.3]), np.array([0.6])]
    np.testing.assert_array_equal(again.value(at), WHOLE.value(at))
    data["parts"][0]["kind"] = "lookup"
    with pytest.raises(EcfitError, match="unknown kind of formula in a part 'lookup'"):
        Composed.from_dict(data, 2)


@pytest.mark.parametrize(
    ("names", "text", "parts", "words"),
    [
        (("mu",), "E", PARTS[:1], "part 'E' is a function of more than mu"),
        (("alpha", "mu"), "E * B", PARTS, "unknown name 'B'"),
        (("alpha", "mu"), "E", (), "needs parts, each name once"),
        (("alpha", "mu"), "E", (PARTS[0], PARTS[0]), "needs parts, each name once"),
        (("alpha", "mu"), "E", (Part("E", ("mu",), E1),), "part 'E' is a function of 2 variables"),
    ],
)
def test_parts_that_do_not_fit_are_told(names, text: str, parts, words: str):
    with pytest.raises(EcfitError, match=words):
        Composed(names, text, parts)
