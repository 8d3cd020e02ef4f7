"""Distances between numbers of single precision, in units in the last place."""

import numpy as np

# Half a unit in the last place of 1. Nearer to zero the unit stays that of this number: a difference of 2^-47 is
# nothing to an albedo, and devices flush what is below 2^-126 to zero.
FLOOR = 2.0**-24


def ulps(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """How many units in the last place of `expected` lie between two float32 numbers, float64.

    The unit is that of max(|expected|, `FLOOR`). Equal numbers are 0 apart, two NaNs too; anything else with an
    infinity or NaN is infinitely far.
    """
    x, y = np.asarray(found, dtype=np.float32), np.asarray(expected, dtype=np.float32)
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    with np.errstate(invalid="ignore"):
        unit = np.spacing(np.maximum(np.abs(y), np.float32(FLOOR)))
        apart = np.abs(x.astype(np.float64) - y.astype(np.float64)) / unit.astype(np.float64)
    return np.where(same, 0.0, np.where(np.isnan(apart), np.inf, apart))
