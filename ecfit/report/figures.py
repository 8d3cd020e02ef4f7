"""The figures of a report. Each function returns a Matplotlib figure; nothing is written here."""

import re
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ecfit.approximation import Approximation
from ecfit.approximation.standing import standing
from ecfit.fitting import Fit
from ecfit.fitting.selection import Choice, front
from ecfit.metrics import Errors, predict, signed_error
from ecfit.report.entries import Entry
from ecfit.report.plots import against_cost, curve, error_along, image, plane
from ecfit.report.style import COLOURS, INK, MARKERS, SIGNED, VALUES, look
from ecfit.tables import Table

Published = Sequence[tuple[Approximation, Errors]]


def _mark(fit: Fit) -> str:
    """What a number of a fit that may not be used is marked with."""
    return "" if fit.ok else " *"


def _otherwise(approximation: Approximation, table: Table) -> str:
    """In which conventions a published fit differs from the table it is judged on."""
    differences = approximation.contract.differences(table.contract)
    return f" ({', '.join(differences)})" if differences else ""


def _published_label(approximation: Approximation, table: Table) -> str:
    return approximation.name + _otherwise(approximation, table)


def degree_vs_error(name: str, table: Table, fits: Sequence[Fit], published: Published = ()) -> Figure:
    """Sforza & Pellacini 2022, figure 3: coefficients and MAE by degree, and MAE against coefficients."""
    families = list(dict.fromkeys(f.approximation.form for f in fits))
    # A family of one fit beside others is a point, not a column.
    points = [n for n in families if len(families) > 1 and sum(f.approximation.form == n for f in fits) == 1]
    families = [n for n in families if n not in points] or families
    points = [n for n in points if n not in families]
    single = [f for f in fits if f.approximation.form in points]
    fits = [f for f in fits if f.approximation.form in families]
    degrees = list(dict.fromkeys(f.approximation.degree for f in fits))
    degrees.sort(key=lambda d: [int(part) for part in re.findall(r"\d+", d)])
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
                row += [str(fit.approximation.count), f"{fit.mae:.2e}{_mark(fit)}"] if fit else ["", ""]
            cells.append(row)
        header = ["degree"] + [cell for f in families for cell in (f"{f}\ncoefficients", f"{f}\nMAE")]
        printed = left.table(cellText=cells, colLabels=header, loc="center", cellLoc="center")
        printed.auto_set_font_size(False)
        printed.set_fontsize(8)
        printed.scale(1.0, 1.25)
        for (row, _), cell in printed.get_celld().items():
            cell.set_linewidth(0.3)
            if row == 0:
                cell.set_height(cell.get_height() * 1.7)
                cell.set_text_props(weight="bold")
        for family in families:
            rows = sorted(
                (f.approximation.count, f.mae, f.ok) for f in fits if f.approximation.form == family
            )
            x, y, ok = (np.array(column) for column in zip(*rows, strict=True))
            colour, marker = COLOURS.get(family, COLOURS["other"]), MARKERS.get(family, "D")
            right.plot(x, y, marker=marker, color=colour, label=family, markersize=4, linewidth=1.2)
            if not ok.all():
                right.plot(
                    x[~ok], y[~ok], marker, markersize=8, markerfacecolor="none", markeredgecolor=colour,
                    linestyle="none", label=f"{family}: pole or not converged",
                )  # fmt: skip
        for fit in single:
            right.plot(
                fit.approximation.count, fit.mae, "D", markersize=8, markerfacecolor="none", linestyle="none",
                markeredgecolor=COLOURS["other"], label=f"{fit.approximation.name}{_mark(fit)}",
            )  # fmt: skip
        told: set[str] = set()
        for approximation, errors in published:
            kind = standing(approximation)
            # Each published one by its name, those of ecfit together: their numbers tell them apart.
            label = "shipped with ecfit" if kind == "shipped" else _published_label(approximation, table)
            right.plot(
                approximation.count, errors.mae, MARKERS[kind], color=COLOURS[kind], linestyle="none",
                markersize=8 if kind == "shipped" else 11, label=None if label in told else label,
            )  # fmt: skip
            told.add(label)
        right.set(yscale="log", xlabel="number of coefficients", ylabel="mean absolute error")
        right.set_title(name)
        right.grid(True, which="major", alpha=0.3)
        right.legend(frameon=False, fontsize=8)
        if any(not f.ok for f in [*fits, *single]):
            figure.text(0.01, 0.01, "* pole or not converged", fontsize=7)
    return figure


def _planes(table: Table, count: int) -> list[tuple[tuple[int, ...], str]]:
    """Indices of planes of the last two dimensions, spread over the first one, and where they are.

    The dimensions between are cut at their middle. With `count` = 1 the first one is too.
    """
    leading = table.axes[:-2]
    if not leading:
        return [((), "")]
    n = len(leading[0])
    spread = [n // 2] if count == 1 else np.unique(np.round(np.linspace(0, n - 1, count)).astype(int))
    rest = tuple(len(axis) // 2 for axis in leading[1:])
    found = [(int(first), *rest) for first in spread]
    return [
        (i, ", ".join(f"{a.name} = {a.nominal[k]:.3g}" for a, k in zip(leading, i, strict=True)))
        for i in found
    ]


def table_and_fit(name: str, table: Table, fit: Fit) -> Figure:
    """The table, a fit, and the signed error fit - table."""
    predicted = predict(fit.approximation, table)
    error = predicted - table.values
    with look():
        figure = Figure(figsize=(9.6, 3.2), layout="constrained")
        if len(table.axes) == 1:
            left, right = figure.subplots(1, 2)
            curve(left, table, table.values, "table", color=INK)
            curve(left, table, predicted, fit.approximation.name, color=COLOURS["rational"], linestyle="--")
            left.legend(frameon=False)
            curve(right, table, error, "fit - table", color=COLOURS["rational"])
            right.set_title("fit - table")
            return figure
        panels = figure.subplots(1, 3)
        finite = table.values[table.usable]
        low, high = float(finite.min()), float(finite.max())
        bound = float(np.abs(plane(table, error)[0]).max()) or 1.0
        where = ""
        for axes, values, title, cmap, lo, hi in (
            (panels[0], table.values, f"{name}: table", VALUES, low, high),
            (panels[1], predicted, f"fit: {fit.approximation.name}{_mark(fit)}", VALUES, low, high),
            (panels[2], error, f"fit - table, max {fit.max_error:.2e}", SIGNED, -bound, bound),
        ):
            cut, where = plane(table, values)
            mesh = image(axes, table, cut, cmap, lo, hi)
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
                    curve(axes, table, error, color=COLOURS.get(fit.approximation.form, COLOURS["other"]))
                else:
                    cut, where = plane(table, error)
                    bound = float(np.abs(cut).max()) or 1.0
                    mesh = image(axes, table, cut, SIGNED, -bound, bound)
                    ticks = [-bound, 0.0, bound]
                    bar = figure.colorbar(mesh, ax=axes, shrink=0.8, ticks=ticks, format="%.0e")
                    bar.ax.set_yticklabels([f"{-bound:.0e}", "0", f"{bound:.0e}"])
                    bar.ax.tick_params(labelsize=6)
                axes.set_title(f"{fit.approximation.name}{_mark(fit)}", fontsize=8)
                axes.locator_params(nbins=3)
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
            COLOURS.get(f.approximation.form, COLOURS["other"]),
            _mark(f),
            1.0 if f is last[f.approximation.form] else 0.45,
        )
        for f in fits
    ]
    entries += [(a, COLOURS[standing(a)], _otherwise(a, table), 1.0) for a, _ in published]
    with look():
        figure = Figure(figsize=(9.6, 3.8), layout="constrained")
        panels = np.atleast_1d(figure.subplots(1, len(table.axes), sharey=True))
        for approximation, colour, mark, alpha in entries:
            for v, axes in enumerate(panels):
                style = {"color": colour, "alpha": alpha}
                error_along(axes, table, approximation, v, f"{approximation.name}{mark}", **style)
        for axis, axes in zip(table.axes, panels, strict=True):
            axes.set(xlabel=axis.name, yscale="log")
            axes.grid(True, alpha=0.3)
        panels[0].set_ylabel("absolute error\n(line: mean, dashes: max)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize=8)
        figure.suptitle(f"{name}: error along each axis", fontsize=9)
    return figure


def error_against_cost(name: str, rows: Sequence[Entry]) -> Figure:
    """RMS error of everything judged on a table against numbers to store (left) and operations (right)."""
    with look():
        figure = Figure(figsize=(9.6, 3.8), layout="constrained")
        by_count, by_cost = figure.subplots(1, 2, sharey=True)
        against_cost(by_count, rows, "coefficients")
        against_cost(by_cost, rows, "operations")
        by_cost.set_ylabel("")
        handles, labels = by_count.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize=8)
        figure.suptitle(f"{name}: error against cost", fontsize=9)
    return figure


def table_and_estimate(name: str, table: Table) -> Figure:
    """The table and, where there is one, the error estimate of its entries; of 3D tables several planes."""
    rows = [(table.values, VALUES, table.contract.quantity)]
    if table.estimated:
        rows.append((np.log10(np.maximum(table.errors, 1e-16)), "magma", "log10 of the error estimate"))
    with look():
        if len(table.axes) == 1:
            figure = Figure(figsize=(3.6 * len(rows), 3.2), layout="constrained")
            panels = figure.subplots(1, len(rows), squeeze=False)[0]
            for axes, (values, _, title) in zip(panels, rows, strict=True):
                first = axes is panels[0]
                curve(axes, table, values, name if first else "", color=INK)
                axes.set_title(f"{name}: {title}" if first else title)
            return figure
        planes = _planes(table, 4)
        if len(planes) == 1:
            figure = Figure(figsize=(3.6 * len(rows), 3.2), layout="constrained")
            grid = figure.subplots(1, len(rows), squeeze=False).reshape(-1, 1)
        else:
            figure = Figure(figsize=(9.6, 2.4 * len(rows)), layout="constrained")
            grid = figure.subplots(len(rows), len(planes), sharex=True, sharey=True, squeeze=False)
        for line, (values, cmap, title) in zip(grid, rows, strict=True):
            finite = values[table.usable]
            low, high = float(finite.min()), float(finite.max())
            mesh = None
            for axes, (index, where) in zip(line, planes, strict=True):
                mesh = image(axes, table, values[index], cmap, low, high)
                axes.set_title(where or title)
                axes.label_outer()
            assert mesh is not None  # there is at least one plane
            figure.colorbar(mesh, ax=line, shrink=0.9, label=title if len(planes) > 1 else "")
        figure.suptitle(name, fontsize=9)
    return figure


def searches(name: str, found: Sequence[tuple[str, Sequence[Choice]]]) -> Figure:
    """The best forms that searches found: error against coefficients and against operations, with fronts."""
    with look():
        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        by_count, by_cost = figure.subplots(1, 2, sharey=True)
        for i, (form, choices) in enumerate(found):
            colour = f"C{i}"
            errors = [c.rms for c in choices]
            by_count.plot([c.count for c in choices], errors, "o-", color=colour, markersize=3.5, label=form)
            costs = [c.cost.total for c in choices]
            by_cost.plot(costs, errors, "o", color=colour, markersize=3.5, alpha=0.4)
            best = front(choices)
            by_cost.step(
                [c.cost.total for c in best], [c.rms for c in best], where="post", color=colour, linewidth=1.2
            )
        by_count.set(xlabel="coefficients", ylabel="RMS error (weights of the search)", yscale="log")
        by_count.xaxis.set_major_locator(MaxNLocator(integer=True))
        by_cost.set(xlabel="operations, in multiply-adds (line: front)", yscale="log")
        by_count.legend()
        figure.suptitle(f"{name}: what the searches found")
    return figure
