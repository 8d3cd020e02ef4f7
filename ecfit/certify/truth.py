"""Errors against the integrated model at points off any grid: a sample, not a proof."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ecfit.approximation import Approximation
from ecfit.coordinates import VIEWS
from ecfit.errors import EcfitError
from ecfit.expressions import value
from ecfit.quadrature.refine import Status
from ecfit.tables.scattered import Scattered

# Integrals are used where their error estimate is at most this: far below the error of any fit.
LOOSE = 1e-6

Range = tuple[float, float]
Points = dict[str, np.ndarray]


@dataclass(frozen=True)
class Sampling:
    """A rule for random points: uniform in r = sqrt(alpha), mu and sqrt(F0), others uniform in their domain.

    Attributes:
        count: number of points.
        seed: of the generator.
        ranges: of r, mu and s = sqrt(F0), within the approximation's domain; s over all of it by default.
            Rougher than 0.03 and steeper than 0.02 is what renderers use; the rest is measured apart.
        logarithmic: coordinates that are uniform in their logarithm instead.

    Raises `EcfitError` for less than 1 point.
    """

    count: int = 20_000
    seed: int = 1
    ranges: Mapping[str, Range] = field(default_factory=lambda: {"r": (0.03, 1.0), "mu": (0.02, 1.0)})
    logarithmic: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not isinstance(self.count, int) or self.count < 1:
            raise EcfitError(f"a sample needs 1 point or more, got {self.count!r}")

    def points(self, approximation: Approximation) -> Points:
        """Coordinates of the approximation, one array (count,) each.

        Raises `EcfitError` where a range has nothing in common with the domain.
        """
        rng = np.random.default_rng(self.seed)
        out = {}
        for name, (low, high) in zip(approximation.variables, approximation.domain, strict=True):
            scale, inverse = _SCALES.get(name, (name, _same)), _INVERSES.get(name, _same)
            ends = float(inverse(np.float64(low))), float(inverse(np.float64(high)))
            given = self.ranges.get(scale[0], ends)
            start, end = max(given[0], ends[0]), min(given[1], ends[1])
            if not start < end:
                raise EcfitError(
                    f"sample: {scale[0]} in [{given[0]:g}, {given[1]:g}] lies outside the domain "
                    f"[{ends[0]:g}, {ends[1]:g}] of '{approximation.name}'"
                )
            if scale[0] in self.logarithmic and start > 0.0:
                drawn = np.exp(rng.uniform(np.log(start), np.log(end), self.count))
            else:
                drawn = rng.uniform(start, end, self.count)
            out[name] = np.clip(scale[1](drawn), low, high)
        return out

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary."""
        ranges = {name: list(ends) for name, ends in self.ranges.items()}
        return {**asdict(self), "ranges": ranges, "logarithmic": list(self.logarithmic)}


def _same(x: np.ndarray) -> np.ndarray:
    return x


def _square(x: np.ndarray) -> np.ndarray:
    return x * x


def _ior(s: np.ndarray) -> np.ndarray:
    return np.asarray(VIEWS["F0"].map.forward(s * s))


# Coordinate -> (name of what is uniform, from that to the coordinate), and the way back.
_SCALES = {"alpha": ("r", _square), "r": ("r", _same), "F0": ("s", _square), "ior": ("s", _ior)}
_INVERSES = {
    "alpha": np.sqrt,
    "F0": np.sqrt,
    "ior": lambda ior: np.sqrt(np.asarray(VIEWS["F0"].map.inverse(ior))),
}


@dataclass(frozen=True)
class SampledErrors:
    """Errors at a sample of points; absolute, unweighted.

    Attributes:
        points: how many points counted; loose: those of them where the integral's error estimate is above
            the tolerance but not above `ecfit.certify.truth.LOOSE`; skipped: where it is higher.
        mae, rmse, max_error: mean absolute, root mean square and largest error.
        place: coordinates of the largest error.
        furnace_mean, furnace_p99, furnace_max: of |E_true / E - 1|: the deviation of a white furnace that
            is normalised by the approximation.
    """

    points: int
    loose: int
    skipped: int
    mae: float
    rmse: float
    max_error: float
    place: Mapping[str, float]
    furnace_mean: float
    furnace_p99: float
    furnace_max: float

    def short(self) -> str:
        """A short line: no furnace, no numbers of points."""
        at = ", ".join(f"{k} = {v:.4g}" for k, v in self.place.items())
        return f"MAE {self.mae:.3e}, RMSE {self.rmse:.3e}, largest {self.max_error:.3e} at {at}"

    def describe(self) -> str:
        """One line."""
        notes = [f"{self.loose} of them integrated to {LOOSE:g} only"] if self.loose else []
        notes += [f"{self.skipped} more left out, as not even that was reached"] if self.skipped else []
        tail = f" ({', '.join(notes)})" if notes else ""
        return (
            f"{self.short()}; furnace mean {self.furnace_mean:.2%}, 99 % {self.furnace_p99:.2%}, "
            f"largest {self.furnace_max:.2%}; {self.points} points{tail}"
        )


def measure(
    approximation: Approximation, points: Points, truth: Scattered, kind: str = "float64"
) -> SampledErrors | None:
    """Errors at points where the integral is known; None where it is known at none of them.

    Args:
        truth: what `integrate` gave under the approximation's contract.
        kind: the type of all operations, inputs and constants: "float16" for what half precision gives.
    """
    usable = np.isfinite(truth.values) & (truth.errors <= LOOSE)
    if not usable.any():
        return None
    used = {n: p[usable] for n, p in points.items()}
    if kind == "float64":
        predicted = np.asarray(approximation.formula.value([used[n] for n in approximation.variables]))
    else:
        with np.errstate(all="ignore"):
            narrow = {n: p.astype(kind) for n, p in used.items()}
            found = np.asarray(value(approximation.expression(), narrow), dtype=np.float64)
        predicted = np.broadcast_to(found, truth.values[usable].shape)
    true = truth.values[usable]
    error = np.abs(predicted - true)
    error = np.where(np.isfinite(error), error, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        furnace = np.abs(true / predicted - 1.0)
    furnace = np.where((predicted > 0.0) & np.isfinite(furnace), furnace, np.inf)
    worst = int(np.argmax(error))
    return SampledErrors(
        points=int(usable.sum()),
        loose=int((truth.status[usable] != Status.CONVERGED).sum()),
        skipped=int((~usable).sum()),
        mae=float(error.mean()),
        rmse=float(np.sqrt(np.mean(error**2))),
        max_error=float(error[worst]),
        place={n: float(p[worst]) for n, p in used.items()},
        furnace_mean=float(furnace.mean()),
        # A value of the sample: some may be infinite.
        furnace_p99=float(np.quantile(furnace, 0.99, method="higher")),
        furnace_max=float(furnace.max()),
    )


def corner_points(approximation: Approximation, count: int, seed: int) -> Points:
    """Points with r from 0.03 down to 0.001, and with mu from 0.02 down to 0.0001, half each.

    Empty where the approximation has neither coordinate.
    """
    names = set(approximation.variables)
    halves = []
    if names & {"r", "alpha"}:
        halves.append({"r": (1e-3, 0.03), "mu": (1e-3, 1.0)})
    if "mu" in names:
        halves.append({"r": (0.03, 1.0), "mu": (1e-4, 0.02)})
    drawn = []
    for i, ranges in enumerate(halves):
        try:
            drawn.append(Sampling(count, seed + i, ranges, ("r", "mu")).points(approximation))
        except EcfitError:  # the domain ends before the corner
            continue
    return {n: np.concatenate([d[n] for d in drawn]) for n in approximation.variables} if drawn else {}
