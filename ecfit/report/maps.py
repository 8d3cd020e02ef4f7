"""Signed-error maps as small images for a page: one a row of the report, each with its own scale."""

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from PIL import Image

from ecfit.metrics import signed_error
from ecfit.report.entries import Entry
from ecfit.report.plots import plane
from ecfit.report.style import SIGNED
from ecfit.tables import Table

# A side of a map in pixels: it is shown two to four times as large, and weighs about 2 kB.
_SIDE = 48
# Levels of the colour map: steps of 3 % of the bound, with one for 0.
_LEVELS = 63


@dataclass(frozen=True, eq=False)
class Map:
    """Where an approximation is too high (red) and too low (blue).

    Attributes:
        entry: whose.
        bound: error at the ends of the colour scale.
        source: `data:` address of the image; the last axis runs to the right, the one before it upwards.
    """

    entry: Entry
    bound: float
    source: str


@dataclass(frozen=True)
class Maps:
    """The maps of a table: its axes across and up with their ends, and where it is cut."""

    across: str
    up: str
    where: str
    maps: tuple[Map, ...]


def maps(table: Table, rows: Sequence[Entry]) -> Maps | None:
    """The maps of all rows, or nothing for a 1D table."""
    if len(table.axes) < 2:
        return None
    where, found = "", []
    for row in rows:
        error, where = plane(table, signed_error(row.approximation, table))
        # Evenly spaced in the coordinates, whatever the spacing of the nodes.
        up, across = (_nearest(axis.nominal) for axis in table.axes[-2:])
        error = error[np.ix_(up[::-1], across)]
        finite = error[np.isfinite(error)]
        bound = float(np.abs(finite).max()) if finite.size else 0.0
        found.append(Map(row, bound, image(error, bound)))
    names = [f"{a.name} {a.nominal[0]:.3g} to {a.nominal[-1]:.3g}" for a in table.axes[-2:]]
    return Maps(names[1], names[0], where, tuple(found))


def image(error: np.ndarray, bound: float) -> str:
    """The `data:` address of a PNG of an array in [-bound, bound], NaN as 0."""
    scaled = np.nan_to_num(error, nan=0.0, posinf=bound, neginf=-bound) / (bound or 1.0)
    levels = np.rint((scaled + 1.0) * 0.5 * (_LEVELS - 1)).clip(0, _LEVELS - 1).astype(np.uint8)
    indexed = Image.frombytes("P", (levels.shape[1], levels.shape[0]), levels.tobytes())
    indexed.putpalette(_palette())
    buffer = io.BytesIO()
    indexed.save(buffer, "png", optimize=True)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def _palette() -> list[int]:
    colours = mpl.colormaps[SIGNED](np.linspace(0.0, 1.0, _LEVELS))[:, :3]
    return np.rint(255.0 * colours).astype(int).ravel().tolist()


def _nearest(nodes: np.ndarray) -> np.ndarray:
    """Index of the node nearest to each of evenly spaced places."""
    places = np.linspace(nodes[0], nodes[-1], min(_SIDE, 4 * len(nodes)))
    return np.abs(nodes[:, None] - places).argmin(axis=0)
