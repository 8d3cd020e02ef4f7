"""Narrow arithmetic: the rounding error of single precision, bounded; single and half precision, measured."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ecfit.approximation import Approximation
from ecfit.certify.subject import Subject
from ecfit.certify.truth import Points
from ecfit.expressions import Node, value
from ecfit.expressions import interval as iv
from ecfit.expressions.bounds import Examined, Search
from ecfit.expressions.evaluate import evaluate
from ecfit.expressions.interval import Interval
from ecfit.expressions.node import maximum, var
from ecfit.expressions.rounding import Analysis
from ecfit.forms import Minimum
from ecfit.forms.features import untied

# The bound may exceed the largest bound found at a point by this part of it.
_LOOSE = 0.5


def single_bound(subject: Subject, least: Mapping[str, float], limit: int = 60_000) -> Minimum:
    """A bound of the rounding error in single precision over the whole closed domain.

    Args:
        subject: what is evaluated.
        least: proven lower bounds of the divisors, by name.
        limit: boxes examined at most.

    Returns -(largest error) as a minimum: `bound` is minus the proven bound, `value` minus the largest bound
    at a point, with its place in the order of `subject.domain.box`.
    """
    box = dict(subject.domain.box)
    if subject.charted and "rho" in box:
        # Cosines are raised: nearer to the corner the values are those at the least cosine.
        box["rho"] = (max(subject.least_mu, box["rho"][0]), box["rho"][1])
    floors = {node: least[name] for name, _, node in subject.divisors if node is not None}
    # Of a form that is evaluated in the chart: raised cosines only make rho larger.
    floors[var("alpha") + maximum(var("mu"), subject.least_mu)] = 1.0
    search = Search(box, tuple(box), subject.domain.constraint if subject.charted else None)

    def error(lows: np.ndarray, highs: np.ndarray) -> np.ndarray:
        boxes = {n: Interval(lows[:, i], highs[:, i]) for i, n in enumerate(search.names)}
        rho = boxes.pop("rho", None) if subject.charted else None
        analysis = Analysis(subject.plain, rho, floors)
        inputs = {n: analysis.input(0.0, x) for n, x in boxes.items()}
        if subject.charted:
            t = boxes.pop("t")
            inputs["alpha"] = analysis.input(1.0, t)
            inputs["mu"] = analysis.input(1.0, iv.sub(iv.point(1.0), t))
        found = evaluate([subject.plain], inputs, analysis.rules, analysis.constant)[0]
        total = np.broadcast_to(analysis.plain(found), lows.shape[:1])
        return np.where(np.isnan(total), np.inf, total)

    def examine(lows: np.ndarray, highs: np.ndarray) -> Examined:
        centres = 0.5 * (lows + highs)
        unknown = np.full((len(lows), len(search.active)), np.inf)
        return Examined(-error(lows, highs), centres, -error(centres, centres), unknown)

    return search.run(examine, _LOOSE, None, limit)


@dataclass(frozen=True)
class Drift:
    """How evaluation in a narrow type differs from double precision at the same (rounded) points.

    Attributes:
        kind: "float32" or "float16"; all operations, inputs and constants.
        points: how many points.
        largest: largest difference where the narrow value is finite, with its place.
        not_finite: how many values are infinite or NaN, with the place of the first.
    """

    kind: str
    points: int
    largest: float
    place: Mapping[str, float]
    not_finite: int
    not_finite_place: Mapping[str, float]

    def describe(self) -> str:
        """One line."""
        at = ", ".join(f"{k} = {v:.4g}" for k, v in self.place.items())
        out = f"largest difference {self.largest:.3g} at {at}" if self.place else "no finite value"
        if self.not_finite:
            where = ", ".join(f"{k} = {v:.4g}" for k, v in self.not_finite_place.items())
            out += f"; {self.not_finite} of {self.points} not finite, as at {where}"
        return out

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)


def drift(expression: Node, points: Points, kind: str, charted: bool = False) -> Drift:
    """The drift of an expression at points, rounded to the narrow type first; see `Drift`.

    Args:
        expression: of the points' coordinates, and of t, m and rho if `charted`; see `half_safe`.
    """
    dtype = np.dtype(kind)
    with np.errstate(over="ignore", under="ignore"):
        narrow = {n: p.astype(dtype) for n, p in points.items()}
    wide = {n: p.astype(np.float64) for n, p in narrow.items()}
    with np.errstate(all="ignore"):
        if charted:
            reference = value(expression, _chart_inputs(wide))
            found = np.asarray(value(expression, _chart_inputs(narrow)))
        else:
            reference, found = value(expression, wide), np.asarray(value(expression, narrow))
        shape = next(iter(wide.values())).shape
        reference = np.broadcast_to(reference, shape)
        found = np.broadcast_to(found, shape).astype(np.float64)
        difference = np.where(np.isfinite(found), np.abs(found - reference), -1.0)
    bad = np.flatnonzero(~np.isfinite(found))
    worst = int(np.argmax(difference))
    finite = bool(difference[worst] >= 0.0)
    return Drift(
        kind=kind,
        points=len(reference),
        largest=float(difference[worst]) if finite else float("inf"),
        place={n: float(wide[n][worst]) for n in wide} if finite else {},
        not_finite=int(bad.size),
        not_finite_place={n: float(wide[n][bad[0]]) for n in wide} if bad.size else {},
    )


def half_safe(subject: Subject) -> Node | None:
    """The value in t, m and rho, with no power of alpha or mu that underflows; None without the chart."""
    if not (subject.charted and {"alpha", "mu"} <= set(subject.domain.ranges)):
        return None
    return untied(subject.chart)


def _chart_inputs(points: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    alpha, mu = points["alpha"], points["mu"]
    rho = alpha + mu
    one, zero = alpha.dtype.type(1.0), alpha.dtype.type(0.0)
    inside = rho > zero
    return {
        **points,
        "rho": rho,
        "t": np.where(inside, alpha / rho, one),
        "m": np.where(inside, mu / rho, zero),
    }


def hard_points(approximation: Approximation, count: int, seed: int) -> Points:
    """Points where rounding hurts: near 0 on a logarithmic scale, and on the edges of the domain."""
    rng = np.random.default_rng(seed)
    out = {}
    for name, (low, high) in zip(approximation.variables, approximation.domain, strict=True):
        near = low + (high - low) * 10.0 ** rng.uniform(-8.0, 0.0, count)
        even = rng.uniform(low, high, count)
        kind = rng.integers(0, 8, count)
        out[name] = np.select(
            [kind == 0, kind == 1, kind < 5], [np.full(count, low), np.full(count, high), near], even
        )
    return out
