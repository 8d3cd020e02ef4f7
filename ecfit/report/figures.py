"""The figures of a report. Each function returns a Matplotlib figure; nothing is written here."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecfit.approximation import Approximation
from ecfit.fitting import Fit
from ecfit.metrics import Errors, predict, signed_error
from ecfit.report.style import COLOURS, MARKERS, SIGNED, VALUES, look
from ecfit.tables import Table

Published = Sequence[tuple[Approximation, Errors]]

# An image of more points a side than this shows nothing more in a report, and weighs more.
_IMAGE_POINTS = 160


def _mark(fit: Fit) -> str:
    """What a number of a fit that may not be used is marked with."""
    return "" if fit.ok else " *"


def degree_vs_error(name: str, fits: Sequence[Fit], published: Published = ()) -> Figure:
    """Sforza & Pellacini 2022, figure 3: coefficients and MAE by degree, and MAE against coefficients."""
    families = list(dict.fromkeys(f.approximation.form for f in fits))
    degrees = list(dict.fromkeys(f.approximation.degree for f in fits))
    degrees.sort(key=lambda d: [int(part) for part in d.split("/")])
    by_key = {(f.approximation.form, f.approximation.degree): f for f in fits}
    with look():
        figure = Figure(figsize=(9.6, max(3.4, 0.8 + 0.24 * len(degrees))), layout="constrained")
        # A gap, so that the label of the right axis stays clear of the table.
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.1), gridspec_kw={"wspace": 0.12})
        left.axis("off")
        cells = []
        for degree in degrees:
            row = [degree]
            for family in families:
                fit = by_key.get((family, degree))
                row += [str(fit.terms.count), f"{fit.mae:.2e}{_mark(fit)}"] if fit else ["", ""]
            cells.append(row)
        header = ["degree"] + [cell for f in families for cell in (f"{f}\ncoefficients", f"{f}\nMAE")]
        table = left.table(cellText=cells, colLabels=header, loc="center", cellLoc="center")
        table.auto_set_font_size(False)
        table.set_fontsize(8)
        table.scale(1.0, 1.25)
        for (row, _), cell in table.get_celld().items():
            cell.set_linewidth(0.3)
            if row == 0:
                cell.set_height(cell.get_height() * 1.7)
                cell.set_text_props(weight="bold")
        for family in families:
            points = sorted((f.terms.count, f.mae, f.ok) for f in fits if f.approximation.form == family)
            x, y, ok = (np.array(column) for column in zip(*points, strict=True))
            colour, marker = COLOURS.get(family, "#009E73"), MARKERS.get(family, "D")
            right.plot(x, y, marker=marker, color=colour, label=family, markersize=4, linewidth=1.2)
            if not ok.all():
                right.plot(
                    x[~ok], y[~ok], marker, markersize=8, markerfacecolor="none", markeredgecolor=colour,
                    linestyle="none", label=f"{family}: pole or not converged",
                )  # fmt: skip
        for approximation, errors in published:
            right.plot(
                approximation.terms.count, errors.mae, "*", color=COLOURS["published"], markersize=11,
                label=approximation.name, linestyle="none",
            )  # fmt: skip
        right.set(yscale="log", xlabel="number of coefficients", ylabel="mean absolute error")
        right.set_title(f"{name}: mean absolute error against number of coefficients")
        right.grid(True, which="major", alpha=0.3)
        right.legend(frameon=False, fontsize=8)
        if any(not f.ok for f in fits):
            figure.text(0.01, 0.01, "* pole or not converged", fontsize=7)
    return figure


def _plane(table: Table, values: np.ndarray) -> tuple[np.ndarray, str]:
    """The last two dimensions of a table's array, at the middle of the others, and where that is."""
    where = []
    for axis in table.axes[:-2]:
        middle = len(axis) // 2
        values = values[middle]
        where.append(f"{axis.name} = {axis.nominal[middle]:.3g}")
    return values, ", ".join(where)


def _thin(values: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """At most `_IMAGE_POINTS` a side, ends kept."""
    picks = [
        np.unique(np.round(np.linspace(0, n - 1, min(n, _IMAGE_POINTS))).astype(int)) for n in values.shape
    ]
    return values[np.ix_(*picks)], picks


def _image(axes: Axes, table: Table, values: np.ndarray, cmap: str, low: float, high: float):
    """An image over the last two axes, in the coordinates that a fit sees."""
    plane, where = _plane(table, values)
    thin, picks = _thin(plane)
    y, x = (a.nominal[p] for a, p in zip(table.axes[-2:], picks, strict=True))
    mesh = axes.pcolormesh(x, y, thin, cmap=cmap, vmin=low, vmax=high, shading="nearest", rasterized=True)
    axes.set(xlabel=table.axes[-1].name, ylabel=table.axes[-2].name)
    return mesh, where


def _curve(axes: Axes, table: Table, values: np.ndarray, label: str, **style) -> None:
    axes.plot(table.axes[0].nominal, values, label=label, **style)
    axes.set_xlabel(table.axes[0].name)


def table_and_fit(name: str, table: Table, fit: Fit) -> Figure:
    """The table, a fit, and the signed error fit - table."""
    predicted = predict(fit.approximation, table)
    error = predicted - table.values
    with look():
        figure = Figure(figsize=(9.6, 3.2), layout="constrained")
        if len(table.axes) == 1:
            left, right = figure.subplots(1, 2)
            _curve(left, table, table.values, "table", color="black")
            _curve(left, table, predicted, fit.approximation.name, color=COLOURS["rational"], linestyle="--")
            left.legend(frameon=False)
            _curve(right, table, error, "fit - table", color=COLOURS["rational"])
            right.set_title("fit - table")
            return figure
        panels = figure.subplots(1, 3)
        finite = table.values[table.usable]
        low, high = float(finite.min()), float(finite.max())
        bound = float(np.abs(_plane(table, error)[0]).max()) or 1.0
        where = ""
        for axes, values, title, cmap, lo, hi in (
            (panels[0], table.values, f"{name}: table", VALUES, low, high),
            (panels[1], predicted, f"fit: {fit.approximation.name}{_mark(fit)}", VALUES, low, high),
            (panels[2], error, f"fit - table, max {fit.max_error:.2e}", SIGNED, -bound, bound),
        ):
            mesh, where = _image(axes, table, values, cmap, lo, hi)
            axes.set_title(title)
            figure.colorbar(mesh, ax=axes, shrink=0.9)
        if where:
            figure.suptitle(f"at {where}")
    return figure


def error_maps(name: str, table: Table, fits: Sequence[Fit]) -> Figure:
    """Signed error of every fit, one map each, each with its own symmetric scale."""
    # A family starts a new row; at most five maps stand side by side.
    families = [
        [f for f in fits if f.approximation.form == form]
        for form in dict.fromkeys(f.approximation.form for f in fits)
    ]
    rows = [family[i : i + 5] for family in families for i in range(0, len(family), 5)]
    columns = max(map(len, rows))
    with look():
        figure = Figure(figsize=(9.6, 2.05 * len(rows) + 0.4), layout="constrained")
        grid = figure.subplots(len(rows), columns, squeeze=False)
        where = ""
        for row, line in zip(rows, grid, strict=True):
            for axes in line[len(row) :]:
                axes.axis("off")
            for fit, axes in zip(row, line, strict=False):
                error = signed_error(fit.approximation, table)
                if len(table.axes) == 1:
                    _curve(axes, table, error, "", color=COLOURS.get(fit.approximation.form, "black"))
                else:
                    bound = float(np.abs(_plane(table, error)[0]).max()) or 1.0
                    mesh, where = _image(axes, table, error, SIGNED, -bound, bound)
                    ticks = [-bound, 0.0, bound]
                    bar = figure.colorbar(mesh, ax=axes, shrink=0.8, ticks=ticks, format="%.0e")
                    bar.ax.set_yticklabels([f"{-bound:.0e}", "0", f"{bound:.0e}"])
                    bar.ax.tick_params(labelsize=6)
                axes.set_title(f"{fit.approximation.name}{_mark(fit)}", fontsize=8)
                axes.tick_params(labelsize=6)
        at = f" at {where}" if where else ""
        figure.suptitle(f"{name}: fit - table{at} (red: the fit is too high)", fontsize=9)
    return figure


def error_along_axes(name: str, table: Table, fits: Sequence[Fit], published: Published = ()) -> Figure:
    """Mean (lines) and largest (dashes) absolute error over the other axes, along each axis."""
    # Of one family the last, which is its best, stands out.
    last = {f.approximation.form: f for f in fits}
    entries = [
        (
            f.approximation,
            COLOURS.get(f.approximation.form, "#009E73"),
            _mark(f),
            1.0 if f is last[f.approximation.form] else 0.45,
        )
        for f in fits
    ]
    entries += [(a, COLOURS["published"], "", 1.0) for a, _ in published]
    with look():
        figure = Figure(figsize=(9.6, 3.8), layout="constrained")
        panels = np.atleast_1d(figure.subplots(1, len(table.axes), sharey=True))
        for approximation, colour, mark, alpha in entries:
            error = np.abs(signed_error(approximation, table))
            for v, axes in enumerate(panels):
                others = tuple(i for i in range(error.ndim) if i != v)
                _, (picks,) = _thin(table.axes[v].nominal)
                x = table.axes[v].nominal[picks]
                style = {"color": colour, "alpha": alpha}
                axes.plot(
                    x,
                    error.mean(axis=others)[picks],
                    label=f"{approximation.name}{mark}",
                    linewidth=1.3,
                    **style,
                )
                if others:
                    axes.plot(x, error.max(axis=others)[picks], "--", linewidth=0.8, **style)
        for axis, axes in zip(table.axes, panels, strict=True):
            axes.set(xlabel=axis.name, yscale="log")
            axes.grid(True, alpha=0.3)
        panels[0].set_ylabel("absolute error\n(line: mean, dashes: max)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize=8)
        figure.suptitle(f"{name}: error along each axis", fontsize=9)
    return figure


def table_and_estimate(name: str, table: Table) -> Figure:
    """The table and the error estimate of its entries."""
    with look():
        figure = Figure(figsize=(7.2, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        estimate = np.log10(np.maximum(table.errors, 1e-16))
        if len(table.axes) == 1:
            _curve(left, table, table.values, name, color="black")
            _curve(right, table, estimate, "", color="black")
        else:
            finite = table.values[table.usable]
            mesh, _ = _image(left, table, table.values, VALUES, float(finite.min()), float(finite.max()))
            figure.colorbar(mesh, ax=left, shrink=0.9)
            usable = estimate[table.usable]
            mesh, _ = _image(right, table, estimate, "magma", float(usable.min()), float(usable.max()))
            figure.colorbar(mesh, ax=right, shrink=0.9)
        left.set_title(f"{name}: {table.contract.quantity}")
        right.set_title("log10 of the error estimate")
    return figure
