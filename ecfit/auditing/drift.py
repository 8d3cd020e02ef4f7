"""How far numbers are from the integral."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ecfit.auditing.reading import Reading
from ecfit.tables.scattered import integrate

# A mistake of convention moves nearly all entries: this part of them, the worst, may be wrong for another
# reason (and one entry may be in any case) without hiding it.
_TRIMMED = 0.02


@dataclass(frozen=True, eq=False)
class Drift:
    """Absolute differences from the integral at some entries.

    Attributes:
        entries: flat indices of the entries that were compared, in the order of the sample.
        values, truth: both sides, one an entry.
        skipped: entries left out because their integral is not known well enough.
    """

    entries: np.ndarray
    values: np.ndarray
    truth: np.ndarray
    skipped: int

    @property
    def size(self) -> np.ndarray:
        """Absolute differences; infinite where a value is NaN."""
        off = np.abs(self.values - self.truth)
        return np.where(np.isfinite(off), off, np.inf)

    @property
    def mean(self) -> float:
        return float(self.size.mean())

    @property
    def p99(self) -> float:
        """The 99th percentile, an entry of the sample."""
        return float(np.quantile(self.size, 0.99, method="higher"))

    @property
    def largest(self) -> float:
        return float(self.size.max())

    @property
    def _bulk(self) -> np.ndarray:
        worst = max(1, int(_TRIMMED * self.size.size))
        return np.sort(self.size)[:-worst] if self.size.size > worst else self.size

    @property
    def trimmed_mean(self) -> float:
        """The mean without the worst entries: what a convention is judged by."""
        return float(self._bulk.mean())

    @property
    def trimmed_largest(self) -> float:
        """The largest but for the worst entries."""
        return float(self._bulk.max())

    def beyond(self, tolerance: float) -> np.ndarray:
        """Places in the sample where the difference exceeds the tolerance, the worst first."""
        order = np.argsort(-self.size, kind="stable")
        return order[self.size[order] > tolerance]

    def describe(self, reading: Reading) -> str:
        """One line; `reading` names the place of the largest."""
        worst = int(np.argmax(self.size))
        return (
            f"mean {self.mean:.2g}, 99 % {self.p99:.2g}, largest {self.largest:.2g} "
            f"at {at(reading.place(int(self.entries[worst])))} "
            f"({self.values[worst]:.6g} there, {self.truth[worst]:.6g} integrated)"
        )


def at(place: Mapping[str, float]) -> str:
    """A place in words."""
    return ", ".join(f"{name} = {x:.4g}" for name, x in place.items())


def drift_of(reading: Reading, entries: np.ndarray, tolerance: float) -> Drift:
    """Compare entries with the integral, taken to a tenth of the tolerance.

    Raises `EcfitError` for a contract without a registered model and for points outside its domain.
    """
    goal = 0.1 * tolerance
    truth = integrate(reading.contract, reading.points(entries), goal)
    known = np.isfinite(truth.values) & (truth.errors <= tolerance)
    values = reading.values.ravel()[entries]
    return Drift(entries[known], values[known], truth.values[known], int(np.count_nonzero(~known)))
