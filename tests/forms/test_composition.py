"""Composed forms name their parts; what cannot be read is refused."""

import pytest

from ecfit.errors import EcfitError
from ecfit.forms import Composition, form


def test_it_knows_its_parts():
    made = form("composed", text="E1 * S", parts={"E1": "conductor-10", "S": "glossy-15"})
    assert isinstance(made, Composition)
    assert made.parts == (("E1", "conductor-10"), ("S", "glossy-15"))
    assert made.degree == "conductor-10+glossy-15"
    assert made.count(3) == 0
    assert not made.linear


@pytest.mark.parametrize(
    ("text", "parts", "words"),
    [
        ("E * B", {"E": "one"}, "unknown name 'B'"),
        ("E *", {"E": "one"}, "formula"),
        ("E", {}, "needs parts"),
        ("E", {"E 1": "one"}, "'E 1' is no name of a part"),
    ],
)
def test_nonsense_is_refused(text, parts, words):
    with pytest.raises(EcfitError, match=words):
        Composition(text, parts)
