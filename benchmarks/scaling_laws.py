"""Laws of cost: straight lines and power laws through measurements, and how far off they are."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Law(NamedTuple):
    """A law with what it is worth: the largest |measured / law - 1|, and R2 of the logarithms.

    `coefficients` of a line: (at 0, slope); of a power law: (factor, exponent, ...).
    """

    coefficients: tuple[float, ...]
    deviation: float
    r2: float

    def quality(self) -> str:
        """For people."""
        return f"{100.0 * self.deviation:.0f} %, R2 {self.r2:.4f}"


def line(x: Sequence[float], y: Sequence[float]) -> Law:
    """y = a + b x with the least relative errors, a and b >= 0."""
    xs, ys = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    columns = np.stack([np.ones_like(xs), xs], axis=1) / ys[:, None]
    found = np.linalg.lstsq(columns, np.ones_like(ys), rcond=None)[0]
    if found.min() < 0.0:  # a constant that is lost in the noise
        kept = int(np.argmax(found))
        ratio = columns[:, kept]
        found = np.zeros(2)
        found[kept] = ratio.sum() / (ratio @ ratio)
    predicted = found[0] + found[1] * xs
    return _judged(tuple(float(v) for v in found), ys, predicted)


def power(y: Sequence[float], *x: Sequence[float]) -> Law:
    """y = c x1^e1 x2^e2 ... with the least errors of log y."""
    ys = np.asarray(y, dtype=float)
    logs = [np.log(np.asarray(v, dtype=float)) for v in x]
    columns = np.stack([np.ones_like(ys), *logs], axis=1)
    found = np.linalg.lstsq(columns, np.log(ys), rcond=None)[0]
    predicted = np.exp(columns @ found)
    return _judged((float(np.exp(found[0])), *(float(e) for e in found[1:])), ys, predicted)


def _judged(coefficients: tuple[float, ...], measured: np.ndarray, predicted: np.ndarray) -> Law:
    """Deviations of times that span decades are relative; R2 is that of their logarithms."""
    deviation = float(np.max(np.abs(measured / predicted - 1.0)))
    logs = np.log(measured)
    rest, all_ = np.log(measured / predicted), logs - logs.mean()
    spread = float(all_ @ all_)
    return Law(coefficients, deviation, 1.0 - float(rest @ rest) / spread if spread else 1.0)
