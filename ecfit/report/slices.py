"""Slices of truth against approximations, as data that a page draws: curves over the last axis, sliders."""

import base64
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ecfit.metrics import signed_error
from ecfit.report.entries import Entry
from ecfit.report.plots import SHADES, spread
from ecfit.tables import Table

# Points along a curve, curves of a picture, and places of all sliders together: about 6 kB a series.
_POINTS, _CURVES, _PLACES = 41, 5, 11
# Approximations to choose from.
_SERIES = 6


def slices(table: Table, rows: Sequence[Entry]) -> dict[str, Any]:
    """JSON-ready slices of a table and of the errors of at most six approximations.

    Values are 16-bit integers over a stated range, little-endian, base64: truth over [low, high], errors over
    [-bound, bound], so that small errors are as sharp as large values.
    """
    picks = _picks(table)
    mesh = np.ix_(*picks)
    truth = table.values[mesh]
    finite = truth[np.isfinite(truth)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    series = []
    for row in rows[:_SERIES]:
        error = signed_error(row.approximation, table)[mesh]
        bound = float(np.nanmax(np.abs(error))) if np.isfinite(error).any() else 0.0
        series.append({
            "name": row.name, "numbers": row.count, "bound": bound,
            "error": _packed(error, -bound, bound),
        })  # fmt: skip
    return {
        "quantity": table.contract.quantity,
        "axes": [
            {"name": axis.name, "at": [float(f"{x:.6g}") for x in axis.nominal[pick]]}
            for axis, pick in zip(table.axes, picks, strict=True)
        ],
        "low": low,
        "high": high,
        "truth": _packed(truth, low, high),
        "series": series,
        "shades": list(SHADES),
    }


def _picks(table: Table) -> list[np.ndarray]:
    """Nodes of each axis that are shown: many of the last, few of the one before, sliders over the others."""
    leading = max(0, len(table.axes) - 2)
    # Four dimensions have two sliders, of as many places each as there is room for.
    places = max(2, math.floor((_PLACES * 2 ** max(0, leading - 1)) ** (1.0 / max(1, leading))))
    most = [*([places] * leading), _CURVES, _POINTS][-len(table.axes) :]
    return [spread(len(axis), n) for axis, n in zip(table.axes, most, strict=True)]


def _packed(values: np.ndarray, low: float, high: float) -> str:
    """Base64 of unsigned 16-bit integers: 0 is low, 65534 is high, 65535 is no number."""
    width = (high - low) or 1.0
    with np.errstate(invalid="ignore"):
        scaled = np.clip(np.rint((values - low) / width * 65534.0), 0.0, 65534.0)
    return base64.b64encode(np.where(np.isfinite(scaled), scaled, 65535.0).astype("<u2").tobytes()).decode(
        "ascii"
    )
