"""Places between the guards where a fitted form breaks its limits: they become guards of the next descent."""

from collections.abc import Mapping

import numpy as np

from ecfit.expressions import value
from ecfit.fitting.descent import Descent, Rows
from ecfit.forms import Structure
from ecfit.forms.corner import ChartDomain
from ecfit.forms.structured import chart_points

# Points looked at: a sequence of even spread; most of what it misses, the certificate finds.
_POINTS = 20_000
# So many become guards at once, the worst: always as many, so that few shapes are compiled.
_ADDED = 128
# Q', of mean 1, is watched below this: half of what guards hold.
_LEAST_Q = 1e-3


def weak_points(
    structure: Structure,
    coefficients: np.ndarray,
    domain: Mapping[str, tuple[float, float]],
    margin: float = 0.0,
) -> dict[str, np.ndarray] | None:
    """Points of the closed domain where Q' nearly vanishes, or what the head holds is below half the margin.

    Returns coordinates of `_ADDED` points (the worst, repeated where there are fewer), or None.
    """
    chart = ChartDomain.of(domain)
    points = _spread(len(chart.box))
    inside = {
        n: low + (high - low) * u for (n, (low, high)), u in zip(chart.box.items(), points.T, strict=True)
    }
    if chart.constraint is not None:
        keep = ~chart.constraint({n: (p, p) for n, p in inside.items()})
        inside = {n: p[keep] for n, p in inside.items()}
    coordinates = {n: np.asarray(p) for n, p in _coordinates(inside, chart).items()}
    _, held, q = structure.chart(coefficients)
    shape = next(iter(coordinates.values())).shape
    at = chart_points(coordinates)
    with np.errstate(all="ignore"):
        q_ = np.broadcast_to(value(q, at), shape)
        lacks = [_LEAST_Q - q_ / np.mean(np.abs(q_))]
        lacks += [0.5 * margin - np.broadcast_to(value(node, at), shape) for node in held]
    # In parts of what is usual, so that both kinds compare.
    sizes = [max(float(np.median(np.abs(lack))), 1e-12) for lack in lacks]
    worst = np.max([lack / size for lack, size in zip(lacks, sizes, strict=True)], axis=0)
    worst = np.where(np.isnan(worst), np.inf, worst)
    order = np.argsort(-worst, kind="stable")
    order = order[worst[order] > 0.0][:_ADDED]
    if not len(order):
        return None
    return {n: np.resize(p[order], _ADDED) for n, p in coordinates.items()}


def watched(descent: Descent, structure: Structure, points: Mapping[str, np.ndarray]) -> None:
    """Add guards to a descent of all terms of a structure."""
    old, columns = descent.guards, structure.columns(points)
    descent.guards = Rows(
        np.concatenate([old.factors, structure.held_factors(points)], axis=-1),
        np.concatenate([old.data, structure.data(points)], axis=-1),
    )
    descent.guard_columns = [
        np.concatenate(pair) for pair in zip(descent.guard_columns, columns, strict=True)
    ]


def _spread(dimensions: int) -> np.ndarray:
    """Evenly spread points of the unit cube, shape (points, dimensions): the R sequence (Roberts 2018)."""
    # The root of x^(d + 1) = x + 1: golden ratio for one dimension.
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (dimensions + 1.0))
    steps = (1.0 / root) ** np.arange(1, dimensions + 1)
    inner = (0.5 + np.arange(1, _POINTS + 1)[:, None] * steps) % 1.0
    # A tenth each lies on a lower and an upper face: limits are touched there.
    out = inner.copy()
    rows = np.arange(_POINTS)
    for k in range(dimensions):
        out[rows % (10 * dimensions) == 10 * k + 3, k] = 0.0
        out[rows % (10 * dimensions) == 10 * k + 7, k] = 1.0
    return out


def _coordinates(inside: Mapping[str, np.ndarray], chart: ChartDomain) -> dict[str, np.ndarray]:
    points = dict(inside)
    if "t" in points:
        # 1e-12 stands for the corner itself, where mu / alpha would be lost.
        t, rho = points.pop("t"), np.maximum(points.pop("rho"), 1e-12)
        points |= {"alpha": rho * t, "mu": rho * (1.0 - t)}
    return {n: np.clip(points[n], *ends) if ends[0] > 0.0 else np.minimum(points[n], ends[1])
            for n, ends in chart.ranges.items()}  # fmt: skip
