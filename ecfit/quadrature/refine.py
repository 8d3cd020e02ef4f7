"""Refinement: each entry climbs the levels of its measure until its error estimate meets the tolerance."""

import enum
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


class Status(enum.IntEnum):
    """How the integration of one entry ended."""

    CONVERGED = 0
    TOLERANCE_NOT_MET = 1
    NOT_FINITE = 2


STATUS = {
    Status.CONVERGED: "the error estimate meets the tolerance",
    Status.TOLERANCE_NOT_MET: "the finest rule's error estimate exceeds the tolerance",
    Status.NOT_FINITE: "the integral is NaN or infinite",
}

# Rounding of a sum of up to 1e5 terms, of nodes that come from 1e-15 exact tables, and of values ~ 1.
_ROUNDING = 2e-13


@dataclass(frozen=True)
class Refined:
    """Values, error estimates (absolute), `Status` and level of each entry; arrays of shape (count,)."""

    values: np.ndarray
    errors: np.ndarray
    status: np.ndarray
    level: np.ndarray


def refine(
    evaluate: Callable[[int, np.ndarray], tuple[np.ndarray, np.ndarray]],
    count: int,
    levels: int,
    tolerance: float,
    confirm: bool,
    progress: Callable[[int], None] | None = None,
) -> Refined:
    """Values of `count` entries with error estimates.

    Args:
        evaluate: (level, indices) -> values and error estimates of those entries at that level.
        count: number of entries.
        levels: number of levels.
        tolerance: absolute error to reach.
        confirm: count the change from the level before as an error, and stop at level 1 or later.
        progress: called with the number of entries that finished since the last call.
    """
    values, errors = np.full(count, np.nan), np.full(count, np.inf)
    level_of = np.zeros(count, dtype=np.int8)
    active = np.arange(count)
    for level in range(levels):
        value, error = evaluate(level, active)
        error = error + _ROUNDING * (1.0 + np.abs(value))
        if confirm:
            error = (
                np.maximum(error, np.abs(value - values[active])) if level else np.full_like(error, np.inf)
            )
        values[active], errors[active], level_of[active] = value, error, level
        left = active[~(error <= tolerance)]
        if progress is not None:
            progress(active.size - left.size)
        active = left
        if active.size == 0:
            break
    if progress is not None and active.size:
        progress(active.size)
    status = np.where(errors <= tolerance, Status.CONVERGED, Status.TOLERANCE_NOT_MET).astype(np.int8)
    bad = ~np.isfinite(values)
    status[bad] = Status.NOT_FINITE
    errors[bad] = np.inf
    return Refined(values, errors, status, level_of)


def in_blocks(
    function: Callable[..., Iterable[Any]], arrays: Sequence[np.ndarray], block: int
) -> tuple[np.ndarray, np.ndarray]:
    """Apply a vectorised `function` with two results to rows of `arrays`, in blocks of one fixed size.

    The last block is padded: one size means one compilation, and bounds the memory whatever the number
    of rows.
    """
    count = arrays[0].shape[0]
    out = np.empty(count), np.empty(count)
    for start in range(0, count, block):
        piece = [a[start : start + block] for a in arrays]
        rows = piece[0].shape[0]
        if rows < block:
            piece = [np.concatenate([p, np.broadcast_to(p[-1:], (block - rows,))]) for p in piece]
        for o, result in zip(out, function(*piece), strict=True):
            o[start : start + rows] = np.asarray(result)[:rows]
    return out
