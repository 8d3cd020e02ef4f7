"""Bounds of the rounding error of an expression evaluated in IEEE single precision.

Running error analysis (Wilkinson; Higham 2002, section 3.3) on boxes: beside an interval of its exact value,
each subexpression carries a bound of the error of its computed value, propagated through the operations, each
of which adds u |value| (u = 2^-24) and the least normal number, as GPUs may flush subnormal results to 0.
Fused multiply-adds round less often and keep to the same bound. Inputs are exact single precision numbers;
constants are rounded to single precision.

Near alpha = mu = 0 many expressions are 0 / 0, yet well behaved: alpha = rho t, mu = rho m, and all values
are powers of rho times something regular. Values and errors are therefore kept divided by a power rho^order,
which each operation knows; without a corner all orders are 0.
"""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from ecfit.expressions import interval as iv
from ecfit.expressions.evaluate import Rules
from ecfit.expressions.interval import Interval
from ecfit.expressions.node import Node, topological

UNIT = 2.0**-24
_FLUSHED = 2.0**-126
_OVERFLOW = float(np.finfo(np.float32).max)
# Functions of GPUs and maths libraries: a few units in the last place.
_FUNCTION_UNITS = 8.0
# Each rule rounds less than 100 times in float64 itself.
_INFLATE = 1.0 + 1e-13


class Rounded:
    """rho^order times a value in an interval, computed with an error of at most rho^order `error`."""

    __slots__ = ("error", "order", "value")

    def __init__(self, order: float, value: Interval, error: np.ndarray) -> None:
        self.order: float = order
        self.value: Interval = value
        self.error: np.ndarray = error


class Analysis:
    """Rules for `evaluate` on boxes.

    Args:
        root: the expression that will be evaluated.
        rho: its interval on each box, or None without a corner.
        least: proven lower bounds of |divisor| / rho^order, by divisor: intervals alone find them on tiny
            boxes only.
    """

    def __init__(self, root: Node, rho: Interval | None, least: Mapping[Node, float]) -> None:
        self.rho = rho
        self._powers: dict[float, Interval] = {}
        # `evaluate` meets the divisions in this order.
        self._least: Iterator[float] = iter(
            [least.get(n.args[1], 0.0) for n in topological([root]) if n.op == "div"]
        )

    @property
    def rules(self) -> Rules:
        return {
            "neg": lambda x: Rounded(x.order, iv.neg(x.value), x.error),
            "abs": lambda x: Rounded(x.order, iv.absolute(x.value), x.error),
            "add": lambda x, y: self._sum(x, y, iv.add),
            "sub": lambda x, y: self._sum(x, y, iv.sub),
            "mul": self._mul, "div": self._div, "sqrt": self._sqrt,
            "min": lambda x, y: self._choice(x, y, iv.minimum),
            "max": lambda x, y: self._choice(x, y, iv.maximum),
            "exp": lambda x: self._exp(x, iv.exp, 1.0), "exp2": lambda x: self._exp(x, iv.exp2, np.log(2.0)),
            "log": self._log, "pow": self._pow,
        }  # fmt: skip

    def constant(self, c: float) -> Rounded:
        """A number, rounded to single precision."""
        with np.errstate(over="ignore"):
            return Rounded(0.0, iv.point(c), np.asarray(abs(float(np.float32(c)) - c)))

    def input(self, order: float, value: Interval) -> Rounded:
        """An exact input: rho^order times a value."""
        return Rounded(order, value, np.zeros(()))

    def plain(self, x: Rounded) -> np.ndarray:
        """The error bound itself, with its power of rho."""
        return _times(x.error, self._scale(x.order))

    def _scale(self, order: float) -> np.ndarray:
        """Upper bound of rho^order."""
        if not order or self.rho is None:
            return np.ones(())
        return self._power(order).high

    def _power(self, order: float) -> Interval:
        """rho^order; the same few orders come up again and again."""
        assert self.rho is not None
        if order not in self._powers:
            self._powers[order] = iv.power(self.rho, order)
        return self._powers[order]

    def _at(self, x: Rounded, order: float) -> Rounded:
        """The same with another order."""
        step = x.order - order
        if not step or self.rho is None:
            return Rounded(order, x.value, x.error)
        scale = self._power(step)
        return Rounded(order, iv.mul(x.value, scale), _times(x.error, scale.high))

    def _rounded(self, order: float, value: Interval, error: np.ndarray, units: float = 1.0) -> Rounded:
        """Add the rounding error of one operation."""
        size = value.magnitude + error
        total = error + units * UNIT * size + _times(np.full((), _FLUSHED), self._scale(-order))
        total = np.where(_times(size, self._scale(order)) < _OVERFLOW, total * _INFLATE, np.inf)
        return Rounded(order, value, total)

    def _sum(self, x: Rounded, y: Rounded, rule: Callable[[Interval, Interval], Interval]) -> Rounded:
        order = min(x.order, y.order)
        x, y = self._at(x, order), self._at(y, order)
        return self._rounded(order, rule(x.value, y.value), x.error + y.error)

    def _choice(self, x: Rounded, y: Rounded, rule: Callable[[Interval, Interval], Interval]) -> Rounded:
        order = max(x.order, y.order)
        x, y = self._at(x, order), self._at(y, order)
        error = np.maximum(x.error, y.error)
        value = rule(x.value, y.value)
        for one, other in ((x, y), (y, x)):  # where it is sure which one is chosen, by its distance
            gap = np.maximum(one.value.low - other.value.high, other.value.low - one.value.high)
            chosen = (value.low == one.value.low) & (value.high == one.value.high) & (gap > 2.0 * error)
            error = np.where(chosen, one.error, error)
        return Rounded(order, value, error)

    def _mul(self, x: Rounded, y: Rounded) -> Rounded:
        value = iv.square(x.value) if x is y else iv.mul(x.value, y.value)
        size_x, size_y = x.value.magnitude, y.value.magnitude
        error = _times(size_x, y.error) + _times(size_y, x.error) + _times(x.error, y.error)
        return self._rounded(x.order + y.order, value, error)

    def _div(self, x: Rounded, y: Rounded) -> Rounded:
        least = np.maximum(y.value.mignitude, next(self._least))
        sure = least > y.error
        below = np.where(sure, least, 1.0)
        value = iv.div(x.value, y.value)
        # Where the interval of the divisor contains 0 its proven bound still limits the quotient.
        most = _times(x.value.magnitude, np.asarray(1.0 / below)) * _INFLATE
        value = iv.intersection(value, Interval(-most, most))
        size = value.magnitude
        error = (x.error + _times(size, y.error)) / np.where(sure, below - y.error, 1.0)
        error = np.where(sure, error * _INFLATE, np.inf)
        return self._rounded(x.order - y.order, value, error)

    def _sqrt(self, x: Rounded) -> Rounded:
        value = iv.sqrt(x.value)
        # |sqrt(a) - sqrt(b)| = |a - b| / (sqrt(a) + sqrt(b)), and at most sqrt(|a - b|).
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.minimum(np.sqrt(x.error), np.where(value.low > 0.0, x.error / value.low, np.inf))
        return self._rounded(0.5 * x.order, value, error)

    def _exp(self, x: Rounded, rule: Callable[[Interval], Interval], rate: float) -> Rounded:
        x = self._at(x, 0.0)
        value = rule(x.value)
        return self._rounded(0.0, value, _times(value.high, np.expm1(rate * x.error)), _FUNCTION_UNITS)

    def _log(self, x: Rounded) -> Rounded:
        x = self._at(x, 0.0)
        sure = x.value.low > x.error
        error = np.where(sure, x.error / np.where(sure, x.value.low - x.error, 1.0), np.inf)
        return self._rounded(0.0, iv.log(x.value), error, _FUNCTION_UNITS)

    def _pow(self, x: Rounded, exponent: float) -> Rounded:
        value = iv.power(x.value, exponent)
        wide = x.value.magnitude + x.error
        if exponent >= 1.0:
            error = _times(exponent * wide ** (exponent - 1.0), x.error)
        else:  # concave: largest at 0
            error = x.error**exponent
        return self._rounded(exponent * x.order, value, error * _INFLATE, _FUNCTION_UNITS)


def _times(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A product of bounds >= 0; 0 x inf is unknown."""
    out = x * y
    return np.where(np.isnan(out), np.inf, out)
