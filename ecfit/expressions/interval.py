"""Interval arithmetic on arrays, rounded outward: proofs about expressions over boxes.

An interval [low, high] contains the exact real value of an expression (its constants being the float64
numbers that they are) for all inputs within their intervals. NumPy rounds to nearest, so each bound is moved
outward by at least one unit in the last place, but not where the result is known to be exact: sums without a
rounding error (Knuth's TwoSum), products and quotients with 0 or 1. Thus 1 - mu at mu = 1 is exactly 0.

Conventions where real arithmetic ends (NaN never appears):
- a divisor that contains 0, log of a negative number: [-inf, inf];
- 0 x inf = 0, as an infinite bound is never attained;
- sqrt, log and powers of an interval that reaches below 0 are those of its part >= 0. Enclosures of such
  arguments dip below 0 by rounding or by dependence (1 - mu^2 at mu = 1); an expression is taken to be real
  where it is claimed to be. An argument wholly below 0 gives [-inf, inf].
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecfit.expressions.evaluate import Rules

# One unit in the last place, relative, of any normal float64 is at most 2^-52.
_ULP = 2.0**-52
_LEAST_NORMAL = 2.0**-1022
_DENORMAL = 5e-324
_LARGEST = np.finfo(np.float64).max
# exp, exp2, log and pow are not correctly rounded; NumPy's (libm or SVML) stay below 4 units in the last
# place. Twice that is allowed for, and the least normal number for results flushed to 0.
LIBM_ULPS = 8.0


class Interval:
    """Arrays of intervals. `low` <= `high`, float64, of shapes that broadcast.

    Objects are compared by identity: x * x of one object is a square, so independent inputs must be
    different objects.
    """

    __slots__ = ("_sign", "high", "low")

    def __init__(self, low: Any, high: Any) -> None:
        self.low: np.ndarray = np.asarray(low, dtype=np.float64)
        self.high: np.ndarray = np.asarray(high, dtype=np.float64)
        self._sign: int | None = None

    @property
    def sign(self) -> int:
        """1 where all intervals are >= 0, -1 where all are <= 0, else 0."""
        if self._sign is None:
            least = self.low.min(initial=np.inf)
            self._sign = 1 if least >= 0.0 else -1 if self.high.max(initial=-np.inf) <= 0.0 else 0
        return self._sign

    @property
    def magnitude(self) -> np.ndarray:
        """Largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def mignitude(self) -> np.ndarray:
        """Least absolute value."""
        return np.maximum(np.maximum(self.low, -self.high), 0.0)

    def __repr__(self) -> str:
        return f"Interval({self.low!r}, {self.high!r})"


def point(x: Any) -> Interval:
    """The interval of one number, exactly."""
    return Interval(x, x)


def whole(shape: tuple[int, ...] = ()) -> Interval:
    """The real line."""
    return Interval(np.full(shape, -np.inf), np.full(shape, np.inf))


def hull(x: Interval, y: Interval) -> Interval:
    """The least interval that contains both."""
    return Interval(np.minimum(x.low, y.low), np.maximum(x.high, y.high))


def intersection(x: Interval, y: Interval) -> Interval:
    """What both contain; enclosures of one value always meet."""
    return Interval(np.maximum(x.low, y.low), np.minimum(x.high, y.high))


# Bounds of one correctly rounded result r, moved by one unit in the last place. Relative steps keep 0; where
# underflow makes them too short, `_small` adds the least float.


def _below(r: np.ndarray) -> np.ndarray:
    out = r - np.abs(r) * _ULP
    return np.where(r == np.inf, _LARGEST, out)


def _above(r: np.ndarray) -> np.ndarray:
    out = r + np.abs(r) * _ULP
    return np.where(r == -np.inf, -_LARGEST, out)


def _product(a: np.ndarray, b: np.ndarray, up: bool) -> np.ndarray:
    """A bound of a b from above or below."""
    r = a * b
    wide = _above(r) if up else _below(r)
    out = np.where((a == 1.0) | (b == 1.0), r, wide)
    small = np.abs(r) < 2.0 * _LEAST_NORMAL
    if small.any():
        step = _DENORMAL if up else -_DENORMAL
        out = np.where(small & (a != 0.0) & (b != 0.0), out + step, out)
    invalid = np.isnan(r)
    return np.where(invalid, 0.0, out) if invalid.any() else out


def _quotient(a: np.ndarray, b: np.ndarray, up: bool) -> np.ndarray:
    """A bound of a / b from above or below, b not 0."""
    r = a / b
    wide = _above(r) if up else _below(r)
    out = np.where(b == 1.0, r, wide)
    small = np.abs(r) < 2.0 * _LEAST_NORMAL
    if small.any():
        step = _DENORMAL if up else -_DENORMAL
        out = np.where(small & (a != 0.0), out + step, out)
    # inf / inf: any non-negative number; the caller's other bounds hold the rest.
    invalid = np.isnan(r)
    return np.where(invalid, 0.0, out) if invalid.any() else out


def _sum(a: np.ndarray, b: np.ndarray, up: bool) -> np.ndarray:
    """A bound of a + b; moved only where the rounding error lies on that side."""
    s = a + b
    t = s - a
    error = (a - (s - t)) + (b - t)
    if up:
        out = np.where(error > 0.0, _above(s), s)
        return np.where((s == -np.inf) & (a > -np.inf) & (b > -np.inf), -_LARGEST, out)
    out = np.where(error < 0.0, _below(s), s)
    return np.where((s == np.inf) & (a < np.inf) & (b < np.inf), _LARGEST, out)


def add(x: Interval, y: Interval) -> Interval:
    return Interval(_sum(x.low, y.low, False), _sum(x.high, y.high, True))


def sub(x: Interval, y: Interval) -> Interval:
    return Interval(_sum(x.low, -y.high, False), _sum(x.high, -y.low, True))


def neg(x: Interval) -> Interval:
    return Interval(-x.high, -x.low)


def mul(x: Interval, y: Interval) -> Interval:
    if x is y:
        return square(x)
    sx, sy = x.sign, y.sign
    if sx > 0 and sy > 0:
        return Interval(_product(x.low, y.low, False), _product(x.high, y.high, True))
    if sx < 0 and sy > 0:
        return Interval(_product(x.low, y.high, False), _product(x.high, y.low, True))
    if sx > 0 and sy < 0:
        return Interval(_product(x.high, y.low, False), _product(x.low, y.high, True))
    if sx > 0:
        return Interval(
            np.minimum(_product(x.low, y.low, False), _product(x.high, y.low, False)),
            np.maximum(_product(x.low, y.high, True), _product(x.high, y.high, True)),
        )
    if sy > 0:
        return mul(y, x)
    pairs = [(a, b) for a in (x.low, x.high) for b in (y.low, y.high)]
    low = np.minimum.reduce([_product(a, b, False) for a, b in pairs])
    high = np.maximum.reduce([_product(a, b, True) for a, b in pairs])
    return Interval(low, high)


def square(x: Interval) -> Interval:
    """x^2, never below 0."""
    least, most = x.mignitude, x.magnitude
    return Interval(np.maximum(_product(least, least, False), 0.0), _product(most, most, True))


def div(x: Interval, y: Interval) -> Interval:
    bad = (y.low <= 0.0) & (y.high >= 0.0)
    some = bool(bad.any())
    low = np.where(bad, 1.0, y.low) if some else y.low
    high = np.where(bad, 1.0, y.high) if some else y.high
    if x.sign > 0 and not some and y.sign > 0:
        out = Interval(_quotient(x.low, high, False), _quotient(x.high, low, True))
    else:
        pairs = [(a, b) for a in (x.low, x.high) for b in (low, high)]
        out = Interval(
            np.minimum.reduce([_quotient(a, b, False) for a, b in pairs]),
            np.maximum.reduce([_quotient(a, b, True) for a, b in pairs]),
        )
    return _or_whole(out, bad) if some else out


def _or_whole(x: Interval, bad: np.ndarray) -> Interval:
    """The whole line where `bad`."""
    return Interval(np.where(bad, -np.inf, x.low), np.where(bad, np.inf, x.high))


def sqrt(x: Interval) -> Interval:
    low, high = np.sqrt(np.maximum(x.low, 0.0)), np.sqrt(np.maximum(x.high, 0.0))
    out = Interval(
        np.where(low == 1.0, np.where(x.low == 1.0, 1.0, _below(low)), _below(low)),
        np.where((high == 1.0) & (x.high == 1.0), 1.0, _above(high)),
    )
    bad = x.high < 0.0
    return _or_whole(out, bad) if bad.any() else out


def _libm(low: np.ndarray, high: np.ndarray) -> Interval:
    """Bounds of results whose error is at most `LIBM_ULPS`."""
    down = low - np.abs(low) * (LIBM_ULPS * _ULP) - _LEAST_NORMAL
    up = high + np.abs(high) * (LIBM_ULPS * _ULP) + _LEAST_NORMAL
    return Interval(np.where(low == np.inf, _LARGEST, down), np.where(high == -np.inf, -_LARGEST, up))


def exp(x: Interval) -> Interval:
    out = _libm(np.exp(x.low), np.exp(x.high))
    return _one_at(Interval(np.maximum(out.low, 0.0), out.high), x, 0.0, 1.0)


def exp2(x: Interval) -> Interval:
    out = _libm(np.exp2(x.low), np.exp2(x.high))
    return _one_at(Interval(np.maximum(out.low, 0.0), out.high), x, 0.0, 1.0)


def log(x: Interval) -> Interval:
    bad = x.high <= 0.0
    out = _libm(np.log(np.maximum(x.low, 0.0)), np.log(np.where(bad, 1.0, x.high)))
    return _or_whole(_one_at(out, x, 1.0, 0.0), bad)


def _one_at(out: Interval, x: Interval, where: float, value: float) -> Interval:
    """Put a result that is known exactly."""
    return Interval(np.where(x.low == where, value, out.low), np.where(x.high == where, value, out.high))


def absolute(x: Interval) -> Interval:
    return Interval(x.mignitude, x.magnitude)


def minimum(x: Interval, y: Interval) -> Interval:
    return Interval(np.minimum(x.low, y.low), np.minimum(x.high, y.high))


def maximum(x: Interval, y: Interval) -> Interval:
    return Interval(np.maximum(x.low, y.low), np.maximum(x.high, y.high))


def power(x: Interval, exponent: float) -> Interval:
    """x^exponent; exponents that are not whole are of the part of x that is >= 0."""
    if exponent == 0.0:
        return point(1.0)
    if exponent < 0.0:
        return div(point(1.0), power(x, -exponent))
    if exponent == int(exponent) and x.sign <= 0:
        if exponent % 2 == 0:
            return power(absolute(x), exponent)
        ends = [np.sign(e) * np.abs(e) ** exponent for e in (x.low, x.high)]
        return _one_at(_one_at(_libm(*ends), x, 0.0, 0.0), x, 1.0, 1.0)
    low, high = np.maximum(x.low, 0.0), np.maximum(x.high, 0.0)
    out = _libm(low**exponent, high**exponent)
    out = Interval(np.maximum(out.low, 0.0), np.where(high == 0.0, 0.0, out.high))
    out = _one_at(out, x, 1.0, 1.0)
    bad = x.high < 0.0
    return _or_whole(out, bad) if bad.any() else out


INTERVAL: Rules = {
    "neg": neg, "sqrt": sqrt, "exp": exp, "exp2": exp2, "log": log, "abs": absolute, "pow": power,
    "add": add, "sub": sub, "mul": mul, "div": div, "min": minimum, "max": maximum,
}  # fmt: skip


def box(ranges: Mapping[str, tuple[Any, Any]]) -> dict[str, Interval]:
    """Inputs of `evaluate` from (low, high) by name: a separate object for each."""
    return {name: Interval(low, high) for name, (low, high) in ranges.items()}
