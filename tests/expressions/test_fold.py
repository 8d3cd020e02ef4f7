"""Tidied expressions have the same values and fewer operations."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ecfit.expressions import const, cost, maximum, minimum, parse, sqrt, value, var
from ecfit.expressions.fold import folded


def test_constants_are_formed_once():
    node = folded(parse("x*(0.5 - 2/(3*3.141592653589793)) + sqrt(4)", ("x",)))
    assert node is var("x") * (0.5 - 2 / (3 * 3.141592653589793)) + 2.0


def test_what_is_not_finite_stays_visible():
    node = folded(const(1.0) / const(0.0) + sqrt(var("x")))
    assert cost(node).divisions == 1


NUMBERS = st.sampled_from([-1.0, 0.0, 1e-6, 0.25, 0.5, 1.0, 2.0])


@settings(max_examples=60)
@given(st.lists(st.tuples(st.booleans(), NUMBERS), min_size=1, max_size=4))
def test_limits_within_limits_are_merged_without_changing_the_value(limits):
    node = var("x")
    for upper, c in limits:
        node = minimum(node, c) if upper else maximum(node, c)
    x = np.linspace(-2.0, 3.0, 101)
    np.testing.assert_array_equal(value(folded(node), {"x": x}), value(node, {"x": x}))
    assert cost(folded(node)).comparisons <= cost(node).comparisons


def test_a_clamp_and_a_guard_are_two_comparisons():
    guarded = maximum(minimum(maximum(var("mu"), 0.0), 1.0), 1e-6)
    assert folded(guarded) is minimum(maximum(var("mu"), 1e-6), 1.0)
