"""Refinement: each entry climbs the levels of its measure until its error estimate meets the tolerance."""

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass

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

# Rounding: a sum of up to 1e5 terms of size ~ 1 in 64 bits, pairwise or blocked.
_ROUNDING = 1e-14
# The estimate of a level's error is the last change times the observed rate of convergence, with a margin.
# The rate is not trusted below this: two levels can agree by accident.
_BEST_RATE = 0.03
_MARGIN = 2.0
# A change that happens to vanish must not hide the one before it, this much reduced.
_MEMORY = 1e-3


@dataclass(frozen=True)
class Refined:
    """Values, error estimates (absolute), `Status` and level of each entry; arrays of shape (count,)."""

    values: np.ndarray
    errors: np.ndarray
    status: np.ndarray
    level: np.ndarray


def estimate_error(value: np.ndarray, change: np.ndarray, previous_change: np.ndarray) -> np.ndarray:
    """Error estimate of the finest of three successive levels.

    `change` is |finest - middle|, `previous_change` |middle - coarsest|. For geometric convergence with
    rate q the error is about change q / (1 - q).
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(previous_change > 0.0, change / previous_change, 0.0)
    rate = np.clip(rate, _BEST_RATE, 1.0)
    estimate = np.maximum(change * rate, _MEMORY * previous_change)
    return _MARGIN * estimate + _ROUNDING * (1.0 + np.abs(value))


def refine(
    evaluate: Callable[[int, np.ndarray], np.ndarray],
    count: int,
    levels: int,
    tolerance: float,
    progress: Callable[[int], None] | None = None,
) -> Refined:
    """Values of `count` entries with error estimates.

    Args:
        evaluate: (level, indices) -> values of those entries at that level, shape (len(indices),).
        count: number of entries.
        levels: number of levels, at least 3.
        tolerance: absolute error to reach.
        progress: called with the number of entries that finished since the last call.
    """
    values = np.full(count, np.nan)
    errors = np.full(count, np.inf)
    level_of = np.zeros(count, dtype=np.int8)
    change = np.full(count, np.inf)
    active = np.arange(count)
    for level in range(levels):
        new = evaluate(level, active)
        old = values[active]
        values[active] = new
        level_of[active] = level
        if level == 0:
            continue
        previous = change[active]
        change[active] = np.abs(new - old)
        if level == 1:
            continue
        errors[active] = estimate_error(new, change[active], previous)
        left = active[~(errors[active] <= tolerance)]
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
    function: Callable[..., np.ndarray], arrays: Sequence[np.ndarray], block: int
) -> np.ndarray:
    """Apply a vectorised `function` to rows of `arrays` in blocks of one fixed size (the last one padded).

    One size means one compilation; the block bounds the memory whatever the number of rows.
    """
    count = arrays[0].shape[0]
    out = np.empty(count)
    for start in range(0, count, block):
        piece = [a[start : start + block] for a in arrays]
        rows = piece[0].shape[0]
        if rows < block:
            piece = [np.concatenate([p, np.broadcast_to(p[-1:], (block - rows,))]) for p in piece]
        out[start : start + rows] = np.asarray(function(*piece))[:rows]
    return out
