"""One look for all figures, and files that are byte-identical from run to run."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl

mpl.use("agg")  # files only: no display is needed or opened

from matplotlib.figure import Figure

# Okabe & Ito 2008: eight colours that people with any colour vision tell apart.
COLOURS = {
    "polynomial": "#0072B2",
    "rational": "#D55E00",
    "published": "#000000",
}
MARKERS = {"polynomial": "o", "rational": "s"}
VALUES, SIGNED = "viridis", "RdBu_r"

_SETTINGS: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "ecfit",
    "savefig.dpi": 150,
    "image.interpolation": "nearest",
    "figure.facecolor": "white",
}


@contextmanager
def look() -> Iterator[None]:
    """The look of our figures, for the duration of a `with`."""
    with mpl.rc_context(_SETTINGS):
        yield


def rendered(figure: Figure, kind: str) -> bytes:
    """A figure as the bytes of an SVG or PNG file, without dates or versions."""
    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    with look():
        figure.savefig(buffer, format=kind, metadata=metadata)
    return buffer.getvalue()
