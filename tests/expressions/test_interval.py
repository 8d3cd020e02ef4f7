"""Intervals contain what exact arithmetic gives, and only widen where a result is not exact."""

import operator
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecfit.expressions import Node, const, jet, maximum, minimum, power, unary, var
from ecfit.expressions import interval as iv
from ecfit.expressions.evaluate import evaluate
from ecfit.expressions.interval import INTERVAL, Interval

EXACT = {
    "neg": operator.neg, "abs": abs, "add": operator.add, "sub": operator.sub, "mul": operator.mul,
    "div": operator.truediv, "min": min, "max": max,
}  # fmt: skip
NUMBERS = st.floats(-8.0, 8.0).map(lambda x: x if abs(x) > 1e-100 else 0.0)


def combine(children: st.SearchStrategy[Node]) -> st.SearchStrategy[Node]:
    pairs = st.tuples(children, children)
    return st.one_of(
        pairs.map(lambda p: p[0] + p[1]),
        pairs.map(lambda p: p[0] - p[1]),
        pairs.map(lambda p: p[0] * p[1]),
        pairs.map(lambda p: p[0] / p[1]),
        pairs.map(lambda p: minimum(*p)),
        pairs.map(lambda p: maximum(*p)),
        children.map(lambda x: -x),
        children.map(lambda x: x * x),
        children.map(lambda x: power(x, 3)),
        children.map(lambda x: unary("abs", x)),
    )


LEAVES = st.one_of(st.just(var("x")), st.just(var("y")), NUMBERS.map(const))
RATIONAL = st.recursive(LEAVES, combine, max_leaves=8)
RANGES = st.tuples(NUMBERS, NUMBERS).map(sorted)
WITHIN = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=4)


def exactly(node: Node, point: dict[str, float]) -> Fraction | None:
    """The value in rational arithmetic; None where something is divided by 0."""
    inputs = {n: Fraction(x) for n, x in point.items()}
    try:
        return Fraction(evaluate([node], inputs, EXACT, Fraction)[0])
    except ZeroDivisionError:
        return None


def contains(x: Interval, value: Fraction) -> bool:
    low, high = float(x.low), float(x.high)
    above = low == -np.inf or Fraction(low) <= value
    return above and (high == np.inf or value <= Fraction(high))


def enclosure(node: Node, box: dict[str, Interval]) -> Interval:
    with np.errstate(all="ignore"):
        return evaluate([node], box, INTERVAL, iv.point)[0]


@settings(max_examples=300)
@given(RATIONAL, RANGES, RANGES, WITHIN)
def test_the_exact_value_lies_within(node: Node, x: list, y: list, places: list[float]):
    found = enclosure(node, iv.box({"x": x, "y": y}))
    assert not np.isnan(found.low)
    assert not np.isnan(found.high)
    assert found.low <= found.high
    for place in places:
        point = {
            n: min(max(low + place * (high - low), low), high) for n, (low, high) in (("x", x), ("y", y))
        }
        value = exactly(node, point)
        assert value is None or contains(found, value)


@settings(max_examples=200)
@given(RATIONAL, RANGES, RANGES)
def test_derivatives_serve_the_mean_value_theorem(node: Node, x: list, y: list):
    box = {"x": Interval(*x), "y": Interval(*y)}
    with np.errstate(all="ignore"):
        variables = {n: jet.variable(v, i) for i, (n, v) in enumerate(box.items())}
        found = evaluate([node], variables, jet.JET, jet.constant)[0]
    ends = exactly(node, {"x": x[0], "y": y[0]}), exactly(node, {"x": x[1], "y": y[1]})
    if None in ends or not np.isfinite(found.value.low):
        return
    # f(b) - f(a) = sum of d_i (b_i - a_i) for some d within the bounds.
    low = high = Fraction(0)
    for i, (a, b) in enumerate((x, y)):
        down, up = (float(d) for d in jet.slopes(found, i, ()))
        if not np.isfinite([down, up]).all():
            return
        low += Fraction(down) * (Fraction(b) - Fraction(a))
        high += Fraction(up) * (Fraction(b) - Fraction(a))
    assert low <= ends[1] - ends[0] <= high


FUNCTIONS = {
    "exp": (st.floats(-700.0, 700.0), lambda x: x.exp()),
    "exp2": (st.floats(-1000.0, 1000.0), lambda x: Decimal(2) ** x),
    "log": (st.floats(1e-300, 1e300), lambda x: x.ln()),
    "sqrt": (st.floats(0.0, 1e300), lambda x: x.sqrt()),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_lie_within_few_units(name: str):
    values, reference = FUNCTIONS[name]

    @given(values)
    def check(x: float):
        with localcontext() as context, np.errstate(all="ignore"):
            context.prec = 60
            true = Fraction(reference(Decimal(x)))
            found = INTERVAL[name](iv.point(x))
        assert contains(found, true)
        assert found.high - found.low <= 40 * np.spacing(max(abs(float(true)), 1e-290)) + 1e-306

    check()


@given(st.floats(1e-3, 1e3), st.sampled_from([0.3, 1.1, 2.7, 70.0, 65.5]))
def test_powers_lie_within(x: float, exponent: float):
    with localcontext() as context:
        context.prec = 60
        true = Fraction((Decimal(exponent) * Decimal(x).ln()).exp())
    assert contains(iv.power(iv.point(x), exponent), true)


def test_powers_of_negative_numbers():
    x = Interval(-2.0, 1.0)
    even, odd = iv.power(x, 66.0), iv.power(x, 65.0)
    assert even.low == 0.0
    assert even.high >= 2.0**66
    assert odd.low <= -(2.0**65)
    assert odd.high == 1.0
    assert iv.power(x, 0.3).low == 0.0
    assert iv.power(Interval(-2.0, -1.0), 0.3).low == -np.inf


def test_exact_results_stay_exact():
    mu = Interval(0.25, 1.0)
    u = iv.sub(iv.point(1.0), mu)
    assert (u.low, u.high) == (0.0, 0.75)
    square = iv.mul(mu, mu)
    assert square.high == 1.0
    assert iv.sub(iv.point(1.0), square).low == 0.0
    assert iv.sqrt(iv.point(1.0)).low == iv.sqrt(iv.point(1.0)).high == 1.0
    assert iv.exp(iv.point(0.0)).low == iv.exp(iv.point(0.0)).high == 1.0
    assert iv.mul(Interval(0.0, 0.3), Interval(0.1, 0.7)).low == 0.0


def test_inexact_results_are_widened_by_one_unit():
    third = iv.div(iv.point(1.0), iv.point(3.0))
    assert Fraction(float(third.low)) < Fraction(1, 3) < Fraction(float(third.high))
    assert third.high - third.low <= 4 * np.spacing(1.0 / 3.0)
    total = iv.add(iv.point(0.1), iv.point(0.2))
    exact = Fraction(0.1) + Fraction(0.2)
    assert Fraction(float(total.low)) <= exact <= Fraction(float(total.high))
    # TwoSum knows the side: one end is the rounded sum itself.
    assert 0.1 + 0.2 in (float(total.low), float(total.high))


def test_the_same_object_multiplied_by_itself_is_a_square():
    x = Interval(-1.0, 2.0)
    assert iv.mul(x, x).low == 0.0
    other = Interval(-1.0, 2.0)
    assert iv.mul(x, other).low <= -2.0


def test_where_real_arithmetic_ends_nothing_is_nan():
    line = (-np.inf, np.inf)

    def ends(x: Interval) -> tuple[float, float]:
        return float(x.low), float(x.high)

    with np.errstate(all="ignore"):
        assert ends(iv.div(iv.point(1.0), Interval(-1.0, 1.0))) == line
        assert ends(iv.div(Interval(0.0, 0.0), Interval(0.0, 1.0))) == line
        assert ends(iv.mul(iv.point(0.0), iv.whole())) == (0.0, 0.0)
        assert ends(iv.sqrt(Interval(-1e-20, 4.0)))[0] == 0.0
        assert ends(iv.sqrt(Interval(-2.0, -1.0))) == line
        assert ends(iv.log(Interval(0.0, 1.0))) == (-np.inf, 0.0)
        assert ends(iv.log(Interval(-2.0, -1.0))) == line
        big = iv.mul(iv.point(1e308), iv.point(1e308))
        assert ends(big)[0] == np.finfo(float).max
        assert ends(big)[1] == np.inf
        assert ends(iv.sub(big, big)) == line
        tiny = iv.mul(iv.point(1e-200), iv.point(-1e-200))
        assert ends(tiny)[0] < 0.0 == ends(tiny)[1] or ends(tiny)[1] > 0.0


def test_arrays_and_scalars_broadcast():
    x = Interval(np.array([0.0, 1.0, -1.0]), np.array([1.0, 2.0, 3.0]))
    out = iv.add(iv.mul(x, iv.point(-2.0)), iv.point(1.0))
    assert np.allclose(out.low, [-1.0, -3.0, -5.0])
    assert np.allclose(out.high, [1.0, -1.0, 3.0])


def test_derivatives_of_functions():
    x = var("x")
    cases = [
        (unary("exp", x), np.exp), (unary("exp2", x), lambda v: np.log(2.0) * 2.0**v),
        (unary("log", x), lambda v: 1.0 / v), (power(x, 0.5), lambda v: 0.5 / np.sqrt(v)),
        (power(x, 0.3), lambda v: 0.3 * v**-0.7), (power(x, 3), lambda v: 3.0 * v * v),
        (1.0 / x, lambda v: -1.0 / v**2), (unary("abs", x - 0.5), lambda v: np.sign(v - 0.5)),
        (minimum(x * x, x), lambda v: np.where(v < 1.0, 2.0 * v, 1.0)),
    ]  # fmt: skip
    low = np.array([0.4, 0.51, 0.9, 1.5])
    high = low + 0.2
    for node, derivative in cases:
        found = evaluate([node], {"x": jet.variable(Interval(low, high), 0)}, jet.JET, jet.constant)[0]
        down, up = jet.slopes(found, 0, low.shape)
        for part in np.linspace(0.0, 1.0, 7):
            at = derivative(low + part * (high - low))
            assert np.all(down <= at + 1e-12), node
            assert np.all(at <= up + 1e-12), node


def test_the_root_at_zero_has_a_derivative_without_upper_bound():
    found = evaluate(
        [power(var("x"), 0.5)], {"x": jet.variable(Interval(0.0, 1.0), 0)}, jet.JET, jet.constant
    )
    down, up = jet.slopes(found[0], 0, ())
    assert 0.0 < down <= 0.5
    assert up == np.inf
