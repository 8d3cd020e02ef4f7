"""The minimum of an expression over a box, bounded from both sides: branch and bound with intervals.

On a box X the expression f is bounded from below by its interval extension and by the mean value form
f(c) + f'(X) (X - c) with c in X, where f'(X) encloses the first derivatives; the better of both counts. c is
placed where the mean value form's lower bound is greatest (Baumann 1988): the lowest corner in a variable
along which f is monotone, else between. Boxes that may hold the minimum are halved, thousands at a time.
All of it is rounded outward, so the bound is a proof.
"""

from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

import numpy as np

from ecfit.errors import EcfitError
from ecfit.expressions import interval as iv
from ecfit.expressions import jet
from ecfit.expressions.evaluate import Rules, evaluate
from ecfit.expressions.interval import Interval
from ecfit.expressions.node import Node, inputs, topological

# Which boxes, given as (lows, highs) by name, lie wholly outside the domain.
Outside = Callable[[Mapping[str, tuple[np.ndarray, np.ndarray]]], np.ndarray]

# Boxes evaluated at once: large enough to hide NumPy's overhead a call, small enough for the caches.
_BATCH = 4096
# Boxes narrower than this part of the domain in every variable are kept as they are.
_NARROWEST = 2.0**-40


class Minimum(NamedTuple):
    """The least value found and its place, and a lower bound of the true minimum."""

    value: float
    place: tuple[float, ...]
    bound: float


def smallest(
    node: Node,
    box: Mapping[str, tuple[float, float]],
    *,
    tolerance: float = 1e-3,
    enough: float | None = None,
    constraint: Outside | None = None,
    floors: Mapping[Node, float] | None = None,
    limit: int = 400_000,
) -> Minimum:
    """The minimum of an expression over a closed box.

    Args:
        node: the expression. Constants are exactly the float64 numbers that they are.
        box: (low, high) of each input, by name; low = high is a fixed one.
        tolerance: stop when value and bound are within this of each other, relative to |value|.
        enough: boxes on which the expression is proven to be at least this are not refined any further: a
            proof of the sign (enough = 0) is then cheap, and the bound no better than it needs to be.
        constraint: tells boxes that lie wholly outside a domain within the box, for which nothing need hold.
        floors: what is proven already of divisors in the expression: divisor >= floor where the floor is
            positive, divisor <= floor where it is negative. A quotient is then bounded on large boxes too.
        limit: boxes examined at most; the bounds then remain apart.

    Returns the least value at a point with its place, in the order of `box`, and a bound that the minimum
    is proven not to be below; -inf where nothing can be said (a pole, an undefined value). `value` is +inf
    where no point gave a finite value.
    Raises `EcfitError` where the box misses an input or has low > high or an end that is not finite.
    """
    missing = sorted(inputs(node) - set(box))
    if missing:
        raise EcfitError(f"bounds: the box has no range for {', '.join(missing)}")
    search = Search(box, inputs(node), constraint)
    return search.run(_mean_value(node, search, floors or {}), tolerance, enough, limit)


class Examined(NamedTuple):
    """What is known of boxes: lower bounds, shape (boxes,); a point of each, shape (boxes, variables), and
    upper bounds of the values there; how far the function may vary along each active variable, or inf."""

    bounds: np.ndarray
    points: np.ndarray
    values: np.ndarray
    swings: np.ndarray


Ends = np.ndarray  # shape (boxes, variables)


class Search:
    """Branch and bound for any function that can be examined on boxes; `smallest` is the usual way in.

    Attributes:
        names: of the variables, in order.
        active: indices of the variables that are split: those of positive width that matter.
    """

    def __init__(
        self, box: Mapping[str, tuple[float, float]], used: Collection[str], outside: Outside | None
    ) -> None:
        self.names: tuple[str, ...] = tuple(box)
        self.outside: Outside | None = outside
        self.low: np.ndarray = np.array([float(low) for low, _ in box.values()])
        self.high: np.ndarray = np.array([float(high) for _, high in box.values()])
        finite = np.all(np.isfinite(self.low)) and np.all(np.isfinite(self.high))
        if not finite or np.any(self.low > self.high):
            raise EcfitError("bounds: a range must be finite, with low <= high")
        self.width: np.ndarray = self.high - self.low
        self.active: list[int] = [
            i
            for i, name in enumerate(self.names)
            if self.width[i] > 0.0 and (name in used or outside is not None)
        ]

    def run(
        self, examine: Callable[[Ends, Ends], Examined], tolerance: float, enough: float | None, limit: int
    ) -> Minimum:
        """The minimum; see `smallest`. `examine` is called with ends of boxes of shape (boxes, variables)."""
        self._examine_some = examine
        self.best: float = np.inf
        self.place: np.ndarray = 0.5 * (self.low + self.high)
        lows, highs = self._initial()
        bounds, split = self._examine(lows, highs, np.full(len(lows), -np.inf))
        done = np.inf  # least bound of the boxes that are not refined any further
        examined = len(lows)
        sufficient = np.inf if enough is None else enough
        while True:
            cut = self._cut(tolerance, sufficient)
            # One that reaches `enough` exactly is done too: t >= 0 needs no refinement towards t = 0.
            leave = (bounds > cut) | (bounds >= sufficient) | (split < 0)
            if leave.any():
                done = min(done, float(bounds[leave].min()))
                lows, highs, bounds, split = (a[~leave] for a in (lows, highs, bounds, split))
            # A box too narrow to split may lie below all others: then no more can be proved.
            if not len(bounds) or done < min(cut, float(bounds.min())) or examined >= limit:
                break
            take = _least(bounds, min(_BATCH, max(1, limit - examined)))
            keep = np.ones(len(bounds), dtype=bool)
            keep[take] = False
            halves = _halved(lows[take], highs[take], split[take])
            parents = np.tile(bounds[take], 2)
            if self.outside is not None:
                inside = ~self.outside(self._named(*halves))
                halves, parents = (halves[0][inside], halves[1][inside]), parents[inside]
            examined += len(parents)
            found, where = self._examine(*halves, parents)
            lows, highs = np.concatenate([lows[keep], halves[0]]), np.concatenate([highs[keep], halves[1]])
            bounds, split = np.concatenate([bounds[keep], found]), np.concatenate([split[keep], where])
        bound = min(done, float(bounds.min(initial=np.inf)), self.best)
        return Minimum(float(self.best), tuple(map(float, self.place)), float(bound))

    def _cut(self, tolerance: float, sufficient: float) -> float:
        """Boxes bounded by more than this need no refinement."""
        cut = self.best - tolerance * abs(self.best) if np.isfinite(self.best) else np.inf
        return min(cut, sufficient)

    def _initial(self) -> tuple[np.ndarray, np.ndarray]:
        """A few hundred boxes: the first sweeps would cost as much with one."""
        pieces = {0: 1, 1: 64, 2: 16, 3: 8, 4: 4}.get(len(self.active), 2)
        lows, highs = self.low[None], self.high[None]
        for i in self.active:
            edges = self.low[i] + self.width[i] * (np.arange(pieces + 1) / pieces)
            edges[-1] = self.high[i]
            count = len(lows)
            lows, highs = np.repeat(lows, pieces, axis=0), np.repeat(highs, pieces, axis=0)
            lows[:, i], highs[:, i] = np.tile(edges[:-1], count), np.tile(edges[1:], count)
        if self.outside is not None:
            inside = ~self.outside(self._named(lows, highs))
            lows, highs = lows[inside], highs[inside]
        return lows, highs

    def _named(self, lows: np.ndarray, highs: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        return {name: (lows[:, i], highs[:, i]) for i, name in enumerate(self.names)}

    def _examine(
        self, lows: np.ndarray, highs: np.ndarray, parents: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Lower bounds on boxes, and the variable along which to halve each (-1: none). Updates the best."""
        bounds, split = parents.copy(), np.full(len(lows), -1)
        for start in range(0, len(lows), 2 * _BATCH):
            rows = slice(start, start + 2 * _BATCH)
            with np.errstate(all="ignore"):
                found = self._examine_some(lows[rows], highs[rows])
            bounds[rows] = np.maximum(bounds[rows], found.bounds)
            split[rows] = self._direction(lows[rows], highs[rows], found.swings)
            self._note(found.points, found.values)
        return bounds, split

    def _note(self, points: np.ndarray, values: np.ndarray) -> None:
        """Keep the least value met at a point of the domain."""
        usable = values < self.best
        if self.outside is not None and usable.any():
            usable &= ~self.outside(self._named(points, points))
        if usable.any():
            k = int(np.argmin(np.where(usable, values, np.inf)))
            self.best, self.place = float(values[k]), points[k].copy()

    def _direction(self, lows: np.ndarray, highs: np.ndarray, swing: np.ndarray) -> np.ndarray:
        """The variable along which the function may vary most; the relatively widest where unknown."""
        if not self.active:
            return np.full(len(lows), -1)
        relative = (highs - lows)[:, self.active] / self.width[self.active]
        known = np.all(np.isfinite(swing), axis=1) & (swing.max(axis=1) > 0.0)
        score = np.where(known[:, None], swing, relative)
        # None gets much thinner than the others: bounds of derivatives mislead where they are poor.
        score = np.where(relative < 1e-3 * relative.max(axis=1, keepdims=True), -1.0, score)
        # Too narrow to halve: as far as the domain goes, or as floats go.
        middle = 0.5 * (lows + highs)[:, self.active]
        stuck = (
            (relative <= _NARROWEST) | (middle <= lows[:, self.active]) | (middle >= highs[:, self.active])
        )
        choice = np.asarray(self.active)[np.argmax(np.where(stuck, -2.0, score), axis=1)]
        return np.where(np.all(stuck, axis=1), -1, choice)


def _mean_value(node: Node, search: Search, floors: Mapping[Node, float]) -> Callable[[Ends, Ends], Examined]:
    """Bounds of an expression by its interval extension and its mean value form."""
    # `evaluate` meets the divisions in this order.
    known = [floors.get(n.args[1], 0.0) for n in topological([node]) if n.op == "div"]

    def jets() -> Rules:
        left = iter(known)

        def div(x: jet.Jet, y: jet.Jet) -> jet.Jet:
            floor = next(left)
            if not floor:
                return jet.div(x, y)
            if search.outside is None:
                return jet.div(x, jet.Jet(_floored(y.value, floor), y.derivatives))
            # Beyond the domain the floor does not hold: the divisor is then replaced by one that it binds.
            bind = jet.maximum if floor > 0.0 else jet.minimum
            return jet.div(x, bind(y, jet.constant(floor)))

        return {**jet.JET, "div": div} if any(known) else jet.JET

    def at_points() -> Rules:
        left = iter(known)
        rules = {**iv.INTERVAL, "div": lambda x, y: iv.div(x, _floored(y, next(left)))}
        return rules if any(known) else iv.INTERVAL

    def examine(lows: Ends, highs: Ends) -> Examined:
        shape = (len(lows),)
        boxes = {n: Interval(lows[:, i], highs[:, i]) for i, n in enumerate(search.names)}
        variables = {
            n: jet.variable(x, i) if i in search.active else jet.Jet(x, {})
            for i, (n, x) in enumerate(boxes.items())
        }
        found = evaluate([node], variables, jets(), jet.constant)[0]
        centres = 0.5 * (lows + highs)
        slopes = {i: jet.slopes(found, i, shape) for i in search.active}
        for i, (down, up) in slopes.items():
            centres[:, i] = _centre(lows[:, i], highs[:, i], down, up)
        points = {n: Interval(centres[:, i], centres[:, i]) for i, n in enumerate(search.names)}
        value = evaluate([node], points, at_points(), iv.point)[0]
        mean, swings = value, np.zeros((len(lows), len(search.active)))
        for k, (i, (down, up)) in enumerate(slopes.items()):
            step = iv.sub(boxes[search.names[i]], points[search.names[i]])
            mean = iv.add(mean, iv.mul(Interval(down, up), step))
            swings[:, k] = np.maximum(np.abs(down), np.abs(up)) * (highs - lows)[:, i]
        bounds = np.broadcast_to(np.maximum(found.value.low, mean.low), shape)
        return Examined(bounds, centres, np.broadcast_to(value.high, shape), swings)

    return examine


def _floored(x: Interval, floor: float) -> Interval:
    """What remains of an interval of a number that is known to be >= floor > 0, or <= floor < 0."""
    if floor > 0.0:
        return Interval(np.maximum(x.low, floor), np.maximum(x.high, floor))
    if floor < 0.0:
        return Interval(np.minimum(x.low, floor), np.minimum(x.high, floor))
    return x


def _centre(low: np.ndarray, high: np.ndarray, down: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Where the mean value form with derivatives in [down, up] has the greatest lower bound."""
    spread = up - down
    inner = (up * low - down * high) / np.where(spread > 0.0, spread, 1.0)
    c = np.where(down >= 0.0, low, np.where(up <= 0.0, high, inner))
    c = np.where(np.isfinite(c), c, 0.5 * (low + high))
    return np.clip(c, low, high)


def _least(bounds: np.ndarray, count: int) -> np.ndarray:
    """Indices of the least bounds."""
    return np.arange(len(bounds)) if len(bounds) <= count else np.argpartition(bounds, count)[:count]


def _halved(lows: np.ndarray, highs: np.ndarray, split: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rows = np.arange(len(lows))
    middle = 0.5 * (lows[rows, split] + highs[rows, split])
    left, right = highs.copy(), lows.copy()
    left[rows, split] = middle
    right[rows, split] = middle
    return np.concatenate([lows, right]), np.concatenate([left, highs])
