"""Pictures of spheres, rows of compensation and columns of roughness, as PNG files."""

import io
import math
import textwrap
from collections.abc import Callable, Sequence
from typing import Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from ecfit.rendering.sphere import Sphere
from ecfit.rendering.verdict import Verdict
from ecfit.report.style import look

mpl.use("agg")

# The furnace's light of 1 is this grey (linear): what is brighter than it shows too.
_WHITE = 0.60
# Behind the spheres of a colour picture.
_PAPER = 0.88
# Inches of a sphere, of the text below it and of the margins; pixels an inch.
_SIZE, _TEXT, _LEFT, _TOP, _DPI = 0.98, 0.30, 1.15, 0.42, 120
# Of a picture's palette.
_COLOURS = 256


class RenderedLike(Protocol):
    """What a picture needs of a rendered sphere."""

    @property
    def sphere(self) -> Sphere: ...
    @property
    def picture(self) -> np.ndarray: ...
    @property
    def verdict(self) -> Verdict | None: ...


def furnace_picture(rendered: Sequence[RenderedLike], rows: Sequence[str], r: Sequence[float]) -> bytes:
    """PNG of a furnace: the spheres of one material, below each the mean and worst deviation from 1."""

    def shown(one: RenderedLike) -> np.ndarray:
        return np.repeat(_srgb(one.picture[..., :1] * _WHITE), 3, axis=-1)

    figure = _grid(rendered, rows, r, shown, _TEXT)
    return _png(figure)


def colour_picture(rendered: Sequence[RenderedLike], rows: Sequence[str], r: Sequence[float]) -> bytes:
    """PNG of a material under the studio's light."""

    def shown(one: RenderedLike) -> np.ndarray:
        colour, coverage = one.picture[..., :3], np.clip(one.picture[..., 3:], 0.0, 1.0)
        return _srgb(_tone(colour) + (1.0 - coverage) * _PAPER)

    return _png(_grid(rendered, rows, r, shown, 0.04))


def _tone(light: np.ndarray) -> np.ndarray:
    """Linear up to 0.7, then bending towards 1, so that lamps keep a shape."""
    knee = 0.7
    above = np.maximum(light - knee, 0.0)
    return np.where(light > knee, knee + (1.0 - knee) * above / (above + (1.0 - knee) * 2.0), light)


def _srgb(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, clipped to [0, 1]."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1.0 / 2.4) - 0.055)


def by_size(value: float) -> float:
    """For sorting deviations: what is not a number deviates most."""
    return math.inf if math.isnan(value) else value


def percent(value: float) -> str:
    """A deviation with three digits at most: 12.3%, 1.23%, 0.12%, 0.01%; beyond all measure: > 1000%."""
    if not math.isfinite(value):
        return "not finite"
    if not value < 10.0:
        return "> 1000%"
    return f"{100.0 * value:.1f}%" if value >= 0.1 else f"{100.0 * value:.2f}%"


def _grid(
    rendered: Sequence[RenderedLike],
    rows: Sequence[str],
    r: Sequence[float],
    shown: Callable[[RenderedLike], np.ndarray],
    text: float,
) -> Figure:
    width, height = _LEFT + _SIZE * len(r), _TOP + (_SIZE + text) * len(rows) + 0.06
    places = {(one.sphere.row, one.sphere.r): one for one in rendered}
    with look():
        figure = Figure(figsize=(width, height), dpi=_DPI)
        for i, row in enumerate(rows):
            bottom = 1.0 - (_TOP + (_SIZE + text) * i + _SIZE) / height
            figure.text(0.06 / width, bottom + 0.5 * _SIZE / height, _label(row), va="center", fontsize=7.5)
            for j, value in enumerate(r):
                one = places[row, value]
                left = (_LEFT + _SIZE * j) / width
                axes = figure.add_axes((left, bottom, _SIZE / width, _SIZE / height))
                axes.imshow(shown(one), interpolation="antialiased")
                axes.set_axis_off()
                middle = left + 0.5 * _SIZE / width
                if i == 0:
                    figure.text(middle, 1.0 - 0.3 / height, f"r = {value:g}", ha="center", fontsize=8)
                if one.verdict is not None:
                    told = f"mean {percent(one.verdict.mean)}\nworst {percent(one.verdict.worst)}"
                    figure.text(middle, bottom - 0.02 / height, told, ha="center", va="top", fontsize=6.5)
    return figure


def _label(row: str) -> str:
    """A row's name in short lines."""
    return "\n".join(textwrap.wrap(row, 16, break_long_words=False))


def _png(figure: Figure) -> bytes:
    """The figure with a palette: a third of the size; flat areas and greys stay exact."""
    buffer = io.BytesIO()
    with look():
        figure.savefig(buffer, format="png", dpi=_DPI, metadata={"Software": None})
    image = Image.open(buffer).convert("RGB")
    small = io.BytesIO()
    image.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(
        small, "PNG", optimize=True
    )
    return small.getvalue()
