"""Plots for notebooks and papers: each draws on one Matplotlib `Axes` and returns it.

`axes` is where to draw, by default a new figure of pyplot. `at` says where a table of more dimensions is cut:
coordinate -> value, of which the nearest node is taken; by default the middle one. Approximations may be fits
of ours, published ones or look-up tables.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError, unknown
from ecfit.fitting import Fit
from ecfit.metrics import measure, predict, signed_error
from ecfit.report.entries import Entry, entries
from ecfit.report.style import COLOURS, INK, MARKERS, SIGNED, VALUES, look
from ecfit.tables import Table

Judged = Approximation | Fit
At = Mapping[str, float]
By = Literal["coefficients", "operations"]

# An image of more points a side than this shows nothing more in a report, and weighs more.
_IMAGE_POINTS = 160
# Curves of one plot that an eye keeps apart.
_CURVES = 5


def plot_table(table: Table, *, at: At | None = None, axes: Axes | None = None) -> Axes:
    """The values of a table over its last two axes as an image, or of a 1D table as a curve.

    Raises `EcfitError` for `at` with a coordinate that the table does not have.
    """
    with look():
        axes = _axes(axes)
        if len(table.axes) == 1:
            curve(axes, table, table.values, color=INK)
            axes.set(ylabel=table.contract.quantity)
            return axes
        finite = table.values[table.usable]
        cut, where = plane(table, table.values, at)
        mesh = image(axes, table, cut, VALUES, float(finite.min()), float(finite.max()))
        _bar(axes, mesh, table.contract.quantity)
        axes.set_title(where)
    return axes


def plot_error(
    approximation: Judged, table: Table, *, at: At | None = None, axes: Axes | None = None
) -> Axes:
    """The signed error, approximation - table, over the last two axes; red where it is too high.

    Raises `EcfitError` where the table does not have the approximation's coordinates.
    """
    found = _approximation(approximation)
    error = signed_error(found, table)
    with look():
        axes = _axes(axes)
        if len(table.axes) == 1:
            curve(axes, table, error, color=COLOURS["rational"])
            axes.axhline(0.0, color=INK, linewidth=0.6)
            axes.set(ylabel=f"{found.name} - table")
            return axes
        cut, where = plane(table, error, at)
        bound = float(np.abs(cut).max()) or 1.0
        _bar(axes, image(axes, table, cut, SIGNED, -bound, bound), f"{found.name} - table")
        axes.set_title(where)
    return axes


def plot_slice(
    table: Table, *approximations: Judged, along: str | None = None, at: At | None = None,
    axes: Axes | None = None,
) -> Axes:  # fmt: skip
    """Truth (lines) against approximations (dashes) along one axis, by default the last.

    Where `at` leaves the axis before it open, several curves of it are drawn, in the colours of their value.
    Raises `EcfitError` for coordinates that the table does not have.
    """
    names = [axis.name for axis in table.axes]
    along = along or names[-1]
    if along not in names:
        raise unknown("axis", along, names)
    kept = names.index(along)
    others = [i for i in range(len(names)) if i != kept]
    family = next((i for i in reversed(others) if names[i] not in (at or {})), None)
    fixed = _indices(table, at)
    shades: Sequence[int | None] = [None]
    if family is not None:
        shades = [int(k) for k in spread(len(table.axes[family]), _CURVES)]
    found = [_approximation(a) for a in approximations]
    arrays = [table.values, *(predict(a, table) for a in found)]
    x = table.axes[kept].nominal
    with look():
        axes = _axes(axes)
        for n, k in enumerate(shades):
            index = tuple(
                slice(None) if i == kept else k if i == family else fixed[i] for i in range(len(names))
            )
            colour = INK if k is None else SHADES[n % len(SHADES)]
            label = None if family is None or k is None else _where(table, {family: k})
            axes.plot(x, arrays[0][index], color=colour, linewidth=1.2, label=label)
            for j, (values, a) in enumerate(zip(arrays[1:], found, strict=True)):
                style = ("--", ":", "-.")[j % 3]
                axes.plot(
                    x, values[index], style, color=colour, linewidth=1.8, label=a.name if n == 0 else None
                )
        rest = {i: fixed[i] for i in others if i != family}
        axes.set(xlabel=along, ylabel=table.contract.quantity, title=_where(table, rest))
        axes.legend(frameon=False, fontsize=8)
    return axes


def plot_error_along(
    approximations: Sequence[Judged], table: Table, along: str, *, axes: Axes | None = None
) -> Axes:
    """Mean (lines) and largest (dashes) absolute error over the other axes, along one axis.

    Raises `EcfitError` for an axis that the table does not have.
    """
    names = [axis.name for axis in table.axes]
    if along not in names:
        raise unknown("axis", along, names)
    with look():
        axes = _axes(axes)
        for n, a in enumerate(map(_approximation, approximations)):
            error_along(axes, table, a, names.index(along), a.name, color=f"C{n}")
        axes.set(xlabel=along, yscale="log", ylabel="absolute error (line: mean, dashes: max)")
        axes.grid(True, alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    return axes


def plot_error_against_cost(
    table: Table, approximations: Sequence[Judged], *, by: By = "coefficients", axes: Axes | None = None
) -> Axes:
    """RMS error on a table against what an approximation costs: numbers to store, or operations.

    Operations are in multiply-adds (`ecfit.expressions.cost`); tables, which fetch, are left out there.
    Raises `EcfitError` where the table does not have an approximation's coordinates.
    """
    fits = [a for a in approximations if isinstance(a, Fit)]
    others = [(a, measure(a, table)) for a in approximations if isinstance(a, Approximation)]
    with look():
        axes = _axes(axes)
        against_cost(axes, entries(table, fits, others), by)
        axes.legend(frameon=False, fontsize=8)
    return axes


def against_cost(axes: Axes, rows: Sequence[Entry], by: By) -> None:
    """Draw RMSE against cost: families as lines, what stands beside them as points, poles as rings."""
    drawn: dict[str, list[tuple[float, Entry]]] = {}
    for row in rows:
        x = float(row.count) if by == "coefficients" else row.operations
        if x is not None and row.errors.rmse > 0.0:
            drawn.setdefault(row.approximation.form if row.kind == "fit" else row.kind, []).append((x, row))
    for family, found in drawn.items():
        found.sort(key=lambda point: point[0])
        kind = found[0][1].kind
        colour = COLOURS.get(family, COLOURS["other"])
        marker = MARKERS.get(family, "D")
        style = "-" if kind == "fit" and len(found) > 1 else "none"
        size = {"fit": 4.5, "published": 10.0, "shipped": 7.0, "table": 6.0}[kind]
        label = {"fit": family, "table": "look-up tables"}.get(kind, kind)
        good = [(x, r.errors.rmse) for x, r in found if r.usable]
        bad = [(x, r.errors.rmse) for x, r in found if not r.usable]
        if good:
            x, y = zip(*good, strict=True)
            axes.plot(x, y, marker=marker, color=colour, markersize=size, linewidth=1.3, linestyle=style,
                      label=label)  # fmt: skip
        if bad:
            x, y = zip(*bad, strict=True)
            axes.plot(x, y, marker=marker, markersize=size + 3.0, markerfacecolor="none", linestyle="none",
                      markeredgecolor=colour, label=f"{label}: pole or not converged")  # fmt: skip
    axes.set(xscale="log", yscale="log", ylabel="RMS error")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("numbers to store" if by == "coefficients" else "operations, in multiply-adds")
    axes.grid(True, which="major", alpha=0.3)


def error_along(
    axes: Axes, table: Table, approximation: Approximation, v: int, label: str, **style: Any
) -> None:
    """Draw the mean and largest absolute error along axis number `v`."""
    error = np.abs(signed_error(approximation, table))
    others = tuple(i for i in range(error.ndim) if i != v)
    picks = spread(len(table.axes[v]), _IMAGE_POINTS)
    x = table.axes[v].nominal[picks]
    axes.plot(x, error.mean(axis=others)[picks], label=label, linewidth=1.3, **style)
    if others:
        axes.plot(x, error.max(axis=others)[picks], "--", linewidth=0.8, **style)


def spread(count: int, most: int) -> np.ndarray:
    """At most `most` indices spread evenly over `count`, ends kept."""
    return np.unique(np.round(np.linspace(0, count - 1, min(count, most))).astype(int))


def plane(table: Table, values: np.ndarray, at: At | None = None) -> tuple[np.ndarray, str]:
    """A plane of the last two dimensions of a table's array, and where that is, in words."""
    last = [a.name for a in table.axes[-2:]]
    for name in at or {}:
        if name in last:
            raise EcfitError(f"'{name}' is an axis of the image: `at` takes the axes before the last two")
    index = _indices(table, at)[:-2]
    return values[index], _where(table, dict(enumerate(index)))


def image(axes: Axes, table: Table, cut: np.ndarray, cmap: str, low: float, high: float) -> QuadMesh:
    """Draw a plane over the last two axes, in the coordinates that a fit sees."""
    picks = [spread(n, _IMAGE_POINTS) for n in cut.shape]
    y, x = (a.nominal[p] for a, p in zip(table.axes[-2:], picks, strict=True))
    thin = cut[np.ix_(*picks)]
    mesh = axes.pcolormesh(x, y, thin, cmap=cmap, vmin=low, vmax=high, shading="nearest", rasterized=True)
    axes.set(xlabel=table.axes[-1].name, ylabel=table.axes[-2].name)
    return mesh


def curve(axes: Axes, table: Table, values: np.ndarray, label: str = "", **style: Any) -> None:
    """Draw a 1D table's array."""
    axes.plot(table.axes[0].nominal, values, label=label, **style)
    axes.set_xlabel(table.axes[0].name)


# Cold to warm, after Okabe & Ito 2008, each with a contrast of 3 : 1 on white and on black.
SHADES = ("#0072B2", "#3E9BD6", "#009E73", "#C98500", "#D55E00")


def _indices(table: Table, at: At | None) -> tuple[int, ...]:
    """The node of each axis: nearest to `at`, or the middle."""
    names = [axis.name for axis in table.axes]
    for name in at or {}:
        if name not in names:
            raise unknown("axis", name, names)
    given = at or {}
    return tuple(
        int(np.argmin(np.abs(axis.nominal - given[axis.name]))) if axis.name in given else len(axis) // 2
        for axis in table.axes
    )


def _where(table: Table, index: Mapping[int, int]) -> str:
    return ", ".join(f"{table.axes[i].name} = {table.axes[i].nominal[k]:.3g}" for i, k in index.items())


def _approximation(judged: Judged) -> Approximation:
    return judged.approximation if isinstance(judged, Fit) else judged


def _axes(axes: Axes | None) -> Axes:
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]


def _bar(axes: Axes, mesh: QuadMesh, label: str) -> None:
    figure = axes.get_figure()
    assert figure is not None  # axes that were removed from theirs cannot be drawn on
    figure.colorbar(mesh, ax=axes, label=label)
