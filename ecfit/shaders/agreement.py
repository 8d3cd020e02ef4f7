"""Values of a tool's program against NumPy's, in units in the last place."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ecfit.export.ulps import exact, ulps
from ecfit.expressions import value
from ecfit.shaders.cases import Case, split

# The part of the domain that a second number is given for.
COMMON = 95.0
# Half a unit in the last place of 1. Nearer to zero the unit stays that of this number: a difference of 2^-47
# is nothing to an albedo.
FLOOR = 2.0**-24
# A target may lose as much again as NumPy's single precision does, as shading languages leave the order of
# operations, roots and quotients some freedom; and an ulp of 1 where NumPy happens to be exact.
AGAIN, ULP = 2.0, 2.0**-23


@dataclass(frozen=True)
class Agreement:
    """How the values of one exported function compare, at points of the closed domain.

    Attributes:
        name: of the function.
        points: how many points.
        worst: largest distance from NumPy's float32 value of the same expression, in ulps.
        place: its coordinates.
        largest: largest absolute difference from NumPy's float32 value.
        exact_common, exact_worst: distances from the exact value (of the same numbers), in ulps: what 95 % of
            uniform points stay below, and the largest.
        error, numpy_error: largest absolute difference from the exact value, of the tool and of NumPy's
            float32.
        not_finite: how many values are NaN or infinite.
        unknown: at how many points NumPy's float32, or the exact value, is NaN or infinite, so that there is
            nothing to compare with.
    """

    name: str
    points: int
    worst: float
    place: Mapping[str, float]
    largest: float
    exact_common: float
    exact_worst: float
    error: float
    numpy_error: float
    not_finite: int
    unknown: int

    @property
    def passes(self) -> bool:
        """Whether all values are finite, NumPy's too, and about as exact as NumPy's float32."""
        finite = not self.not_finite and not self.unknown
        return finite and self.error <= AGAIN * self.numpy_error + ULP

    def describe(self) -> str:
        """One line."""
        at = ", ".join(f"{k} = {v:.6g}" for k, v in self.place.items())
        where = f" at {at}" if self.worst else ""
        bad = f"; {self.not_finite} values are not finite" if self.not_finite else ""
        bad += f"; NumPy's are not at {self.unknown} points" if self.unknown else ""
        return (
            f"{self.name}: at most {self.worst:.3g} ulps from NumPy's float32{where}; "
            f"from the exact value {self.exact_common:.3g} on {COMMON:g} %, "
            f"{self.exact_worst:.3g} at most{bad}"
        )


def agreement(case: Case, given: np.ndarray, found: np.ndarray) -> Agreement:
    """Compare values (n,) float32 at points (n, 4) with NumPy's."""
    inputs = case.inputs(given)
    single = np.broadcast_to(value(case.expression, inputs), found.shape)
    double = exact(case.expression, inputs)
    steps, off = ulps(found, single, FLOOR), ulps(found, double, FLOOR)
    worst, uniform = int(np.argmax(steps)), split(len(found))[0]
    return Agreement(
        name=case.function.name,
        points=len(found),
        worst=float(steps[worst]),
        place={name: float(given[worst, i]) for i, name in enumerate(case.taken.names)},
        largest=_apart(found, single),
        exact_common=float(np.percentile(off[uniform:], COMMON)),
        exact_worst=float(np.max(off)),
        error=_apart(found, double),
        numpy_error=_apart(single, double),
        not_finite=int(np.sum(~np.isfinite(found))),
        unknown=int(np.sum(~(np.isfinite(single) & np.isfinite(double)))),
    )


def _apart(x: np.ndarray, y: np.ndarray) -> float:
    """The largest absolute difference; infinite where one is not finite and the other another number."""
    with np.errstate(invalid="ignore"):
        difference = np.abs(x.astype(np.float64) - y.astype(np.float64))
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    return float(np.max(np.where(same, 0.0, np.where(np.isnan(difference), np.inf, difference))))
