"""The domain of a form in the corner chart: a box in t and rho, less what lies outside the domain.

alpha = rho t and mu = rho (1 - t) lie in their ranges on a part of the box only; `outside` tells boxes that
lie wholly beyond it, for `ecfit.expressions.bounds.smallest`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ecfit.expressions import Node
from ecfit.expressions.bounds import smallest
from ecfit.forms.bernstein import Minimum
from ecfit.forms.rooted import Piece, pieces

Range = tuple[float, float]
Boxes = Mapping[str, tuple[np.ndarray, np.ndarray]]
Outside = Callable[[Boxes], np.ndarray]
# Rounding of a few operations on numbers up to 1, generously.
_ROUNDING = 2e-15


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
    def constraint(self) -> Outside | None:
        """`outside` where the box holds more than the domain, else None."""
        return self.outside if {"alpha", "mu"} <= set(self.ranges) else None

    def outside(self, boxes: Boxes) -> np.ndarray:
        """Which boxes have no point with alpha and mu in their ranges."""
        (t_low, t_high), (rho_low, rho_high) = boxes["t"], boxes["rho"]
        out = np.zeros(len(t_low), dtype=bool)
        for name, low, high in (
            ("alpha", rho_low * t_low, rho_high * t_high),
            ("mu", rho_low * (1.0 - t_high), rho_high * (1.0 - t_low)),
        ):
            if name in self.ranges:
                least, most = self.ranges[name]
                out |= (low - _ROUNDING * (1.0 + low) > most) | (high + _ROUNDING * (1.0 + high) < least)
        return out

    def smallest(
        self,
        node: Node,
        *,
        tolerance: float = 1e-3,
        enough: float | None = None,
        floors: Mapping[Node, float] | None = None,
        limit: int = 200_000,
    ) -> Minimum:
        """The minimum of an expression in the variables of `box` over the closed domain.

        Found in the pieces of `ecfit.forms.rooted`, with at most `limit` boxes each; otherwise as
        `ecfit.expressions.bounds.smallest`. The place is in the order of `box`.
        """
        found = []
        for piece in pieces(self.box, node):
            known = {piece.rooted(n): floor for n, floor in (floors or {}).items()}
            low = smallest(
                piece.rooted(node),
                piece.box,
                tolerance=tolerance,
                enough=enough,
                constraint=self._outside_of(piece),
                floors=known,
                limit=limit,
            )
            at = piece.chart({n: np.asarray(x) for n, x in zip(piece.box, low.place, strict=True)})
            found.append(low._replace(place=tuple(float(at[n]) for n in self.box)))
        least = min(found, key=lambda low: low.value)
        return least._replace(bound=min(low.bound for low in found))

    def _outside_of(self, piece: Piece) -> Outside | None:
        """`outside` for boxes given in a piece's variables."""
        if self.constraint is None:
            return None

        def outside(boxes: Boxes) -> np.ndarray:
            lows = piece.chart({n: low for n, (low, _) in boxes.items()})
            highs = piece.chart({n: high for n, (_, high) in boxes.items()})
            ends = {n: (np.minimum(lows[n], highs[n]), np.maximum(lows[n], highs[n])) for n in lows}
            return self.outside(ends)

        return outside

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
