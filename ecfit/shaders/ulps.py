"""Distances between numbers of single precision, in units in the last place."""

import numpy as np

# The bits of 2^-126.
_LEAST_NORMAL = 0x00800000


def ulps(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """How many float32 numbers one has to step over from one to the other, int64.

    Below the least normal number (2^-126) everything is zero, as devices may flush such numbers to zero. Infinite and NaN values count as numbers beyond the largest, so that a NaN is far from everything but
    itself.
    """
    return np.abs(_place(found) - _place(expected))


def _place(x: np.ndarray) -> np.ndarray:
    """The place of each number in the order of all float32 numbers, 0 at zero."""
    bits = np.asarray(x, dtype=np.float32).view(np.int32).astype(np.int64)
    size = np.maximum((bits & 0x7FFFFFFF) - _LEAST_NORMAL + 1, 0)
    return np.where(bits < 0, -size, size)
