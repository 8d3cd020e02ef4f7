"""Refinement: entries climb the levels of their measure until the error estimates meet the tolerance."""

import enum
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


class Status(enum.IntEnum):
    """How the integration of one entry ended, if it was integrated at all."""

    CONVERGED = 0
    TOLERANCE_NOT_MET = 1
    NOT_FINITE = 2
    GIVEN = 3


STATUS = {
    Status.CONVERGED: "the error estimate meets the tolerance",
    Status.TOLERANCE_NOT_MET: "the finest rule's error estimate exceeds the tolerance",
    Status.NOT_FINITE: "the integral is NaN or infinite",
    Status.GIVEN: "given, not integrated here",
}
# What nobody need be warned of.
FINE = (Status.CONVERGED, Status.GIVEN)

# Rounding of a sum of up to 1e5 terms, of nodes that come from 1e-15 exact tables, and of values ~ 1.
_ROUNDING = 2e-13


@dataclass(frozen=True)
class Refined:
    """Values, error estimates (absolute) and `Status`, shape (rows, entries a row); level, shape (rows,)."""

    values: np.ndarray
    errors: np.ndarray
    status: np.ndarray
    level: np.ndarray


def refine(
    evaluate: Callable[[int, np.ndarray], tuple[np.ndarray, np.ndarray]],
    shape: tuple[int, int],
    levels: int,
    tolerance: float,
    confirm: bool,
    progress: Callable[[int], None] | None = None,
) -> Refined:
    """Values of rows of entries with error estimates; a row climbs until all its entries are good enough.

    Args:
        evaluate: (level, row indices) -> values and error estimates of those rows at that level.
        shape: number of rows, and of entries a row.
        levels: number of levels.
        tolerance: absolute error to reach.
        confirm: count the change from the level before as an error, and stop at level 1 or later.
        progress: called with the number of entries that finished since the last call.
    """
    values, errors = np.full(shape, np.nan), np.full(shape, np.inf)
    level_of = np.zeros(shape[0], dtype=np.int8)
    active = np.arange(shape[0])
    for level in range(levels):
        value, error = evaluate(level, active)
        error = error + _ROUNDING * (1.0 + np.abs(value))
        if confirm:
            error = (
                np.maximum(error, np.abs(value - values[active])) if level else np.full_like(error, np.inf)
            )
        values[active], errors[active], level_of[active] = value, error, level
        left = active[~np.all(error <= tolerance, axis=1)]
        if progress is not None:
            progress((active.size - left.size) * shape[1])
        active = left
        if active.size == 0:
            break
    if progress is not None and active.size:
        progress(active.size * shape[1])
    status = np.where(errors <= tolerance, Status.CONVERGED, Status.TOLERANCE_NOT_MET).astype(np.int8)
    bad = ~np.isfinite(values)
    status[bad] = Status.NOT_FINITE
    errors[bad] = np.inf
    return Refined(values, errors, status, level_of)


def in_blocks(
    function: Callable[..., Iterable[Any]], arrays: Sequence[np.ndarray], block: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Apply a vectorised `function` with two results to rows of `arrays`, in blocks of one fixed size.

    Results have shape (rows, width). The last block is padded: one size means one compilation, and bounds
    the memory whatever the number of rows.
    """
    count = arrays[0].shape[0]
    out = np.empty((count, width)), np.empty((count, width))
    for start in range(0, count, block):
        piece = [a[start : start + block] for a in arrays]
        rows = piece[0].shape[0]
        if rows < block:
            piece = [np.concatenate([p, np.broadcast_to(p[-1:], (block - rows,))]) for p in piece]
        for o, result in zip(out, function(*piece), strict=True):
            o[start : start + rows] = np.asarray(result)[:rows]
    return out
