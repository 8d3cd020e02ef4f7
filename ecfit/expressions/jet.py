"""Intervals of values and of first derivatives, carried along together (forward mode).

`derivatives` holds an interval for each variable on which a value depends; absent means 0. At a kink (min,
max, abs) it is the hull of the derivatives on both sides, which serves the mean value theorem: along a
segment the function is absolutely continuous and its derivative lies in the hull almost everywhere.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ecfit.expressions import interval as iv
from ecfit.expressions.evaluate import Rules
from ecfit.expressions.interval import Interval


class Jet:
    """A value and its derivatives by variable."""

    __slots__ = ("derivatives", "value")

    def __init__(self, value: Interval, derivatives: Mapping[int, Interval]) -> None:
        self.value = value
        self.derivatives: dict[int, Interval] = dict(derivatives)


def constant(c: float) -> Jet:
    """A number."""
    return Jet(iv.point(c), {})


def variable(value: Interval, index: int) -> Jet:
    """The variable with a number `index`."""
    return Jet(value, {index: iv.point(1.0)})


def _merge(
    x: Jet, y: Jet, of_x: Callable[[Interval], Interval], of_y: Callable[[Interval], Interval]
) -> dict[int, Interval]:
    """Sum of the derivatives of x and of y, each multiplied by something."""
    out = {i: of_x(d) for i, d in x.derivatives.items()}
    for i, d in y.derivatives.items():
        part = of_y(d)
        out[i] = iv.add(out[i], part) if i in out else part
    return out


def _same(d: Interval) -> Interval:
    return d


def add(x: Jet, y: Jet) -> Jet:
    return Jet(iv.add(x.value, y.value), _merge(x, y, _same, _same))


def sub(x: Jet, y: Jet) -> Jet:
    return Jet(iv.sub(x.value, y.value), _merge(x, y, _same, iv.neg))


def neg(x: Jet) -> Jet:
    return Jet(iv.neg(x.value), {i: iv.neg(d) for i, d in x.derivatives.items()})


def mul(x: Jet, y: Jet) -> Jet:
    if x is y:
        twice = iv.mul(iv.point(2.0), x.value)
        return _chain(x, iv.square(x.value), twice)
    return Jet(
        iv.mul(x.value, y.value),
        _merge(x, y, lambda d: iv.mul(d, y.value), lambda d: iv.mul(d, x.value)),
    )


def div(x: Jet, y: Jet) -> Jet:
    """(x / y)' = (x' - (x / y) y') / y."""
    value = iv.div(x.value, y.value)
    if not y.derivatives:
        return Jet(value, {i: iv.div(d, y.value) for i, d in x.derivatives.items()})
    top = _merge(x, y, _same, lambda d: iv.neg(iv.mul(value, d)))
    return Jet(value, {i: iv.div(d, y.value) for i, d in top.items()})


def _chain(x: Jet, value: Interval, slope: Interval) -> Jet:
    return Jet(value, {i: iv.mul(slope, d) for i, d in x.derivatives.items()})


def _reciprocal(x: Interval) -> Interval:
    """1 / x of x >= 0, with an infinite end where x reaches 0."""
    low, high = np.maximum(x.low, 0.0), np.maximum(x.high, 0.0)
    with np.errstate(divide="ignore"):
        down = iv._below(1.0 / np.where(high > 0.0, high, np.inf))
        up = np.where(low > 0.0, iv._above(1.0 / np.where(low > 0.0, low, 1.0)), np.inf)
    return Interval(np.maximum(down, 0.0), up)


def sqrt(x: Jet) -> Jet:
    value = iv.sqrt(x.value)
    if not x.derivatives:
        return Jet(value, {})
    slope = iv.mul(iv.point(0.5), _reciprocal(value))
    # Below 0 the root is taken to be 0, with slope 0.
    return _chain(x, value, Interval(np.where(x.value.low < 0.0, 0.0, slope.low), slope.high))


def exp(x: Jet) -> Jet:
    value = iv.exp(x.value)
    return _chain(x, value, value)


def exp2(x: Jet) -> Jet:
    value = iv.exp2(x.value)
    return _chain(x, value, iv.mul(value, iv.log(iv.point(2.0))))


def log(x: Jet) -> Jet:
    return _chain(x, iv.log(x.value), _reciprocal(x.value))


def power(x: Jet, exponent: float) -> Jet:
    value = iv.power(x.value, exponent)
    return _chain(x, value, iv.mul(iv.point(exponent), iv.power(x.value, exponent - 1.0)))


def absolute(x: Jet) -> Jet:
    slope = Interval(np.where(x.value.low >= 0.0, 1.0, -1.0), np.where(x.value.high <= 0.0, -1.0, 1.0))
    return _chain(x, iv.absolute(x.value), slope)


def minimum(x: Jet, y: Jet) -> Jet:
    return _choice(x, y, iv.minimum(x.value, y.value), x.value.high < y.value.low, y.value.high < x.value.low)


def maximum(x: Jet, y: Jet) -> Jet:
    return _choice(x, y, iv.maximum(x.value, y.value), x.value.low > y.value.high, y.value.low > x.value.high)


def _choice(x: Jet, y: Jet, value: Interval, first: np.ndarray, second: np.ndarray) -> Jet:
    """Derivatives of the argument that is sure to be chosen, the hull of both elsewhere."""
    zero = iv.point(0.0)
    out = {}
    for i in {**x.derivatives, **y.derivatives}:
        a, b = x.derivatives.get(i, zero), y.derivatives.get(i, zero)
        both = iv.hull(a, b)
        out[i] = Interval(
            np.where(first, a.low, np.where(second, b.low, both.low)),
            np.where(first, a.high, np.where(second, b.high, both.high)),
        )
    return Jet(value, out)


JET: Rules = {
    "neg": neg, "sqrt": sqrt, "exp": exp, "exp2": exp2, "log": log, "abs": absolute, "pow": power,
    "add": add, "sub": sub, "mul": mul, "div": div, "min": minimum, "max": maximum,
}  # fmt: skip


def slopes(jet: Jet, index: int, shape: tuple[int, ...]) -> tuple[Any, Any]:
    """Bounds of the derivative with respect to a variable, as arrays of a shape."""
    d = jet.derivatives.get(index)
    if d is None:
        return np.zeros(shape), np.zeros(shape)
    return np.broadcast_to(d.low, shape), np.broadcast_to(d.high, shape)
