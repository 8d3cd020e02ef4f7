"""One look for all figures, and files that are byte-identical from run to run."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.table import Cell
from matplotlib.text import Text

# Okabe & Ito 2008: eight colours that people with any colour vision tell apart.
COLOURS = {
    "polynomial": "#0072B2",
    "rational": "#D55E00",
    "published": "#111111",
    "table": "#CC79A7",
    "other": "#009E73",
}
COLOURS["shipped"] = COLOURS["other"]  # they are of the same forms; the marker tells
MARKERS = {"polynomial": "o", "rational": "s", "published": "*", "shipped": "P", "table": "^"}
# Text and lines: near black, and one word for a page to replace where it is dark.
INK = "#111111"
VALUES, SIGNED = "viridis", "RdBu_r"

_SVG_IMAGE_DPI = 72
# Sharp in print at a column's width (3.3 in) and on screens of double density.
_PNG_DPI = 200

_SETTINGS: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "ecfit",
    "image.interpolation": "nearest",
    "figure.facecolor": "white",
    **dict.fromkeys(
        ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color", "axes.titlecolor"),
        INK,
    ),
}


@contextmanager
def look() -> Iterator[None]:
    """The look of our figures, for the duration of a `with`."""
    with mpl.rc_context(_SETTINGS):
        yield


def as_written(figure: Figure) -> Figure:
    """The figure with names as users write them: a dollar sign begins mathematics beside ticks only."""
    ticks = {t for axes in figure.axes for axis in (axes.xaxis, axes.yaxis) for t in axis.findobj(Text)}
    labels = {axis.label for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)}
    cells = {cell.get_text() for cell in figure.findobj(Cell) if isinstance(cell, Cell)}
    for text in {*figure.findobj(Text), *cells}:
        if isinstance(text, Text) and (text not in ticks or text in labels):
            text.set_parse_math(False)
    return figure


def _laid_out(figure: Figure) -> None:
    """Find the places of a figure's parts, once for all formats: that takes longer than drawing.

    Without an engine `savefig` draws once. With one, twice, be it that of `set_layout_engine("none")`,
    which moves nothing.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)


def rendered(figure: Figure, kind: str) -> bytes:
    """A figure as the bytes of an SVG or PNG file, without dates or versions."""
    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    as_written(figure)
    with look():
        _laid_out(figure)
        # Images within an SVG are small: they weigh more than all the rest of a report.
        dpi = _SVG_IMAGE_DPI if kind == "svg" else _PNG_DPI
        figure.savefig(buffer, format=kind, metadata=metadata, dpi=dpi)
    return buffer.getvalue()
