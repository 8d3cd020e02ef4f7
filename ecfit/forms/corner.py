"""The domain of a form in the corner chart: a box in t and rho, less what lies outside the domain.

alpha = rho t and mu = rho (1 - t) lie in their ranges on a part of the box only; `outside` tells boxes that
lie wholly beyond it, for `ecfit.expressions.bounds.smallest`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Range = tuple[float, float]
# Relative rounding of two operations, generously.
_ROUNDING = 1e-15


@dataclass(frozen=True)
class ChartDomain:
    """A domain given in the coordinates, seen in the chart.

    Attributes:
        ranges: closed ranges of the coordinates, by name.
        box: closed ranges of t, rho (where alpha or mu is a coordinate) and the other coordinates.
    """

    ranges: Mapping[str, Range]
    box: Mapping[str, Range]

    @classmethod
    def of(cls, ranges: Mapping[str, Range]) -> "ChartDomain":
        """The chart's box for ranges of alpha and mu within [0, inf), of either, or of neither."""
        box = {n: r for n, r in ranges.items() if n not in ("alpha", "mu")}
        if "alpha" in ranges or "mu" in ranges:
            alpha, mu = ranges.get("alpha", (0.0, 0.0)), ranges.get("mu", (0.0, 0.0))
            # t = alpha / (alpha + mu) grows with alpha and falls with mu; 0 / 0 leaves every t possible.
            least = alpha[0] / (alpha[0] + mu[1]) if alpha[0] > 0.0 else 0.0
            most = alpha[1] / (alpha[1] + mu[0]) if mu[0] > 0.0 else 1.0
            if "mu" not in ranges:
                least = most = 1.0
            elif "alpha" not in ranges:
                least = most = 0.0
            elif least > 0.0:
                least *= 1.0 - _ROUNDING
            box = {"t": (least, min(most * (1.0 + _ROUNDING), 1.0)), **_rho(alpha, mu), **box}
        return cls(dict(ranges), box)

    @property
    def constraint(self) -> Callable[[Mapping[str, tuple[np.ndarray, np.ndarray]]], np.ndarray] | None:
        """`outside` where the box holds more than the domain, else None."""
        return self.outside if {"alpha", "mu"} <= set(self.ranges) else None

    def outside(self, boxes: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
        """Which boxes have no point with alpha and mu in their ranges."""
        (t_low, t_high), (rho_low, rho_high) = boxes["t"], boxes["rho"]
        out = np.zeros(len(t_low), dtype=bool)
        for name, low, high in (
            ("alpha", rho_low * t_low, rho_high * t_high),
            ("mu", rho_low * (1.0 - t_high), rho_high * (1.0 - t_low)),
        ):
            if name in self.ranges:
                least, most = self.ranges[name]
                out |= (low * (1.0 - _ROUNDING) > most) | (high * (1.0 + _ROUNDING) < least)
        return out

    def place(self, at: Mapping[str, float]) -> dict[str, float]:
        """The coordinates of a point of the chart, within their ranges."""
        points = dict(at)
        if "t" in points:
            t, rho = points.pop("t"), points.pop("rho")
            points |= {"alpha": rho * t, "mu": rho * (1.0 - t)}
        return {n: float(np.clip(points[n], *self.ranges[n])) for n in self.ranges}


def _rho(alpha: Range, mu: Range) -> dict[str, Range]:
    low, high = alpha[0] + mu[0], alpha[1] + mu[1]
    return {"rho": (low * (1.0 - _ROUNDING), high * (1.0 + _ROUNDING))}
