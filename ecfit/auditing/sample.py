"""Which entries of a table are integrated again: random ones, and those that look odd."""

import numpy as np

from ecfit.auditing.reading import Reading

# Share of the sample that is spent on entries which stand out from their neighbours.
_ODD = 0.25


def choose(reading: Reading, count: int, seed: int) -> np.ndarray:
    """Flat indices of at most `count` finite entries, increasing.

    A quarter are those that stand out most from their neighbours, so that one wrong entry among a million is
    looked at; the rest are random. At alpha = mu = 0 albedos have no limit: that entry is left out.
    """
    usable = np.isfinite(reading.values).ravel() & ~_corner(reading)
    entries = np.flatnonzero(usable)
    if entries.size <= count:
        return entries
    score = np.where(usable, oddness(reading.values).ravel(), -1.0)
    odd = np.argsort(-score, kind="stable")[: max(1, int(_ODD * count))]
    rest = np.setdiff1d(entries, odd)
    random = np.random.default_rng(seed).choice(rest, count - odd.size, replace=False)
    return np.sort(np.concatenate([odd, random]))


def oddness(values: np.ndarray) -> np.ndarray:
    """How far each entry is from its neighbours' line, in units of the table's unevenness around it.

    The least of the second differences along the axes (a ridge is odd along one axis only), divided by the
    median of its neighbours' own.
    """
    scores = []
    filled = np.where(np.isfinite(values), values, 0.0)
    for axis in range(values.ndim):
        if values.shape[axis] < 5:
            continue
        x = np.moveaxis(filled, axis, 0)
        second = np.zeros_like(x)
        second[1:-1] = np.abs(x[2:] - 2.0 * x[1:-1] + x[:-2])
        # At an end, from the line through the next two.
        second[0] = np.abs(x[0] - 2.0 * x[1] + x[2])
        second[-1] = np.abs(x[-1] - 2.0 * x[-2] + x[-3])
        # A wrong entry raises its neighbours' second differences by half of its own: look two away.
        around = [np.roll(second, shift, axis=0) for shift in (-3, -2, 2, 3)]
        usual = np.median(around, axis=0)
        scores.append(np.moveaxis(second / (usual + 1e-6), 0, axis))
    return np.min(scores, axis=0) if scores else np.zeros_like(filled)


def _corner(reading: Reading) -> np.ndarray:
    points = reading.points(np.arange(reading.values.size))
    rough = next((points[n] for n in ("r", "alpha") if n in points), None)
    if rough is None or "mu" not in points:
        return np.zeros(reading.values.size, dtype=bool)
    return (rough == 0.0) & (points["mu"] == 0.0)
