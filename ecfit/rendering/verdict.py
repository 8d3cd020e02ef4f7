"""From the picture of a furnace to its numbers: how far from 1, beyond what noise makes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

# Rings of equal width in mu from LEAST_MU to 1: the picture depends on mu alone, so a ring's mean has less
# noise than its pixels.
RINGS = 18
# At the very edge of a sphere one pixel spans all that is left of mu.
LEAST_MU = 0.1


@dataclass(frozen=True)
class Verdict:
    """How far a furnace is from 1 where mu >= 0.1.

    Attributes:
        mean: mean over the sphere's picture of the deviation |d| of its rings, noise subtracted.
        worst, worst_mu: the largest of these, and the mu of its ring.
        energy: the mean over the picture less 1, with its sign.
        noise: standard error of `energy`; `worst_noise`: of the worst ring.
        rest: energy of the paths that were cut.
        mu, deviation, error: mu, signed deviation and its standard error of each ring.
    """

    mean: float
    worst: float
    worst_mu: float
    energy: float
    noise: float
    worst_noise: float
    rest: float
    mu: np.ndarray
    deviation: np.ndarray
    error: np.ndarray


def verdict(arrays: Mapping[str, np.ndarray]) -> Verdict:
    """The verdict on what `ecfit.rendering.scene.render` returns.

    The square of a ring's measured deviation has the expectation d^2 + s^2, s its standard error: what counts
    is sqrt(max(d^2 - s^2, 0)).
    """
    inside, value, variance, mu, rest = (
        np.asarray(arrays[name], dtype=np.float64).ravel()
        for name in ("inside", "value", "variance", "mu", "rest")
    )
    seen = inside > 0.0
    place = np.clip(((mu[seen] - LEAST_MU) / (1.0 - LEAST_MU) * RINGS).astype(int), 0, RINGS - 1)

    def ring(values: np.ndarray) -> np.ndarray:
        return np.bincount(place, values, RINGS)

    weight = inside[seen]
    area = ring(weight)
    kept = area > 0.0  # a small picture has no pixel in some rings
    area = area[kept]
    deviation = ring(weight * (value[seen] - 1.0))[kept] / area
    error = np.sqrt(ring(weight**2 * variance[seen])[kept]) / area
    beyond = np.sqrt(np.maximum(deviation**2 - error**2, 0.0))
    worst = int(np.argmax(beyond))
    share = area / area.sum()
    centres = ring(weight * mu[seen])[kept] / area
    return Verdict(
        mean=float(share @ beyond),
        worst=float(beyond[worst]),
        worst_mu=float(centres[worst]),
        energy=float(share @ deviation),
        noise=float(np.sqrt(share**2 @ error**2)),
        worst_noise=float(error[worst]),
        rest=float(np.average(rest[seen], weights=weight)),
        mu=centres,
        deviation=deviation,
        error=error,
    )
