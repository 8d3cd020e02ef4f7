"""Points where exported code is tried: the closed domain, its corners and edges first."""

import itertools
from collections.abc import Sequence

import numpy as np

from ecfit.shaders.program import ARGUMENTS

# Of the points that are not corners, so many parts lie on faces and close to a face. The rest is uniform.
_FACES, _NEAR = 0.125, 0.375
# The last points of a set, so many parts of it, are uniform.
UNIFORM = 1.0 - _FACES - _NEAR
# Points close to a face are uniform in log2 of the distance from it, down to 2^-30 of the range: below that
# mu = 0 is meant.
_DEPTH = 30.0


def points(domain: Sequence[tuple[float, float]], count: int, seed: int = 1) -> np.ndarray:
    """Points (count, 3) float32 of a box, unused coordinates 0.

    First the corners, then points with some coordinates at an end, points close to ends, and uniform ones.
    Rounding to single precision stays within the box where it has such a number.

    Args:
        domain: (low, high) of each coordinate, at most three.
        count: how many, at least the number of corners.
        seed: of the generator.
    """
    rng = np.random.default_rng(seed)
    low, high = np.array(domain, dtype=np.float64).T
    corners = np.array(list(itertools.product(*domain)))[:count]
    rest = count - len(corners)
    unit = rng.random((rest, len(domain)))
    faces, near = int(_FACES * rest), int(_NEAR * rest)
    ends = rng.integers(0, 2, unit.shape)
    unit[:faces] = np.where(rng.random((faces, len(domain))) < 0.5, ends[:faces], unit[:faces])
    close = np.exp2(-_DEPTH * unit[faces : faces + near])
    unit[faces : faces + near] = np.where(ends[faces : faces + near] == 1, 1.0 - close, close)
    found = np.concatenate([corners, low + (high - low) * unit]).astype(np.float32)
    out = np.zeros((count, ARGUMENTS), dtype=np.float32)
    out[:, : len(domain)] = np.clip(found, _up(low), -_up(-high))
    return out


def _up(x: np.ndarray) -> np.ndarray:
    """The least float32 numbers that are not below x."""
    rounded = x.astype(np.float32)
    return np.where(rounded < x, np.nextafter(rounded, np.float32(np.inf)), rounded)
