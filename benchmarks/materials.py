"""Time and true error of the tables of glossy and dielectric materials, in one run.

    pip install -e '.[bench]'
    python benchmarks/materials.py            # tables of 32 x 64 x 64 entries, some minutes
    python benchmarks/materials.py --quick    # small, to see that it works

As in benchmarks/tables.py, a random sample of each table's entries is computed by the method of Sforza &
Pellacini 2022, the whole table by ecfit. Radiance transport, separable masking, and the paper's ranges: F0 in
[0, 1] for glossy layers (eq. 17), in [0.0125, 0.25] for dielectrics from both sides (eq. 20 to 22).
True errors are against integrals that use none of ecfit's code (benchmarks/reference.py).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import common
import numpy as np
import paper_method
import reference
from common import show, timed

import ecfit
from ecfit.coordinates import Grid

Array = np.ndarray

SEED = 20220701
SIDES = ("entering", "leaving")


@dataclass(frozen=True, eq=False)
class Points:
    """Random entries of a grid with axes F0, r, mu: their flat indices and coordinates."""

    grid: Grid
    index: Array
    F0: Array
    r: Array
    mu: Array

    @classmethod
    def of(cls, grid: Grid, count: int) -> "Points":
        index = np.random.default_rng(SEED).choice(grid.size, count, replace=False)
        return cls(grid, index, **grid.nodes_at(index))

    @property
    def ior(self) -> Array:
        with np.errstate(divide="ignore"):
            return (1.0 + np.sqrt(self.F0)) / (1.0 - np.sqrt(self.F0))


@dataclass(frozen=True, eq=False)
class Values:
    """What a method gave at the points, and seconds of the processor for each."""

    values: Array
    cpu: Array

    def __add__(self, other: "Values") -> "Values":
        return Values(self.values + other.values, self.cpu + other.cpu)


class Case(NamedTuple):
    """A table to fill: ecfit's names of it, its true values, and the paper's by order of integration."""

    title: str
    model: ecfit.BSDF
    lobe: str
    exact: Array
    paper: dict[str, Values]


def by_paper(integral: paper_method.Integral, points: Points, eta: Array, order: str) -> Values:
    """One lobe at the points by the paper's method."""
    # Compiled without infinities: F0 = 1 is met to rounding.
    finite = np.minimum(eta, 1e16)
    at = list(zip(points.mu.tolist(), points.r.tolist(), finite.tolist(), strict=True))
    integral(0.5, 0.5, 1.5, order)  # warm-up
    values, times = zip(*(timed(lambda p=p: integral(*p, order)) for p in at), strict=True)
    return Values(np.array(values), np.array([t.cpu for t in times]))


# Written against the public interface of ecfit alone.
def by_ecfit(case: Case, points: Points, tolerance: float) -> tuple[Values, str]:
    """The whole table by ecfit: its values at the points, their mean cost, and a note."""
    axes = {axis.name: axis for axis in points.grid.axes}

    def tabulate() -> ecfit.Table:
        return ecfit.tabulate(
            case.model,
            axes,
            quantity="directional-albedo",
            lobe=case.lobe,
            transport="radiance",
            tolerance=tolerance,
        )

    _, cold = timed(tabulate)
    table, warm = timed(tabulate)
    values, estimates = (a.ravel()[points.index] for a in (table.values, table.errors))
    above = np.mean(np.abs(values - case.exact) > estimates)
    note = (
        f"{warm.wall:.1f} s wall, {warm.cpu:.1f} s CPU "
        f"({cold.wall:.1f} s, {cold.cpu:.1f} s with compilation); "
        f"error above its estimate in {above:.1%} of the sample"
    )
    return Values(values, np.array([warm.cpu / table.values.size])), note


def glossy(points: Points) -> Case:
    """E_F / E_ss. The paper's method pays for E_F only: E_ss came from a table (here, free and exact)."""
    at = list(zip(points.mu.tolist(), points.r.tolist(), points.ior.tolist(), strict=True))
    e_ss = np.array([reference.albedo(mu, r) for mu, r, _ in at])
    exact = np.array([reference.reflection(*p) for p in at]) / e_ss
    paper = {}
    for order in paper_method.ORDERS:
        found = by_paper(paper_method.reflection, points, points.ior, order)
        paper[order] = replace(found, values=found.values / e_ss)
    return Case("glossy", ecfit.model("glossy"), "reflection", exact, paper)


def dielectrics(points: Points, side: str) -> list[Case]:
    """R, T and their sum, seen from one side."""
    eta = points.ior if side == "entering" else 1.0 / points.ior
    at = zip(points.mu.tolist(), points.r.tolist(), points.ior.tolist(), strict=True)
    exact_r, exact_t = np.array([reference.dielectric(*p, side=side) for p in at]).T
    exact_t = exact_t / eta**2  # from energy to radiance
    orders = paper_method.ORDERS
    paper_r = {order: by_paper(paper_method.reflection, points, eta, order) for order in orders}
    paper_t = {order: by_paper(paper_method.transmission, points, eta, order) for order in orders}
    both = {order: paper_r[order] + paper_t[order] for order in orders}
    model = ecfit.model("dielectric", side=side, masking="separable")
    return [
        Case(f"dielectric, {side}: R", model, "reflection", exact_r, paper_r),
        Case(f"dielectric, {side}: T", model, "transmission", exact_t, paper_t),
        Case(f"dielectric, {side}: R + T", model, "all", exact_r + exact_t, both),
    ]


def row(name: str, found: Values, exact: Array) -> list[str]:
    """Cost and errors of one method."""
    cpu, errors = 1e3 * found.cpu, np.abs(found.values - exact)
    spread = f"{cpu.std(ddof=1) / math.sqrt(cpu.size):.2g}" if cpu.size > 1 else ""
    return [
        name,
        f"{cpu.mean():.4g}",
        spread,
        f"{errors.max():.1e}",
        f"{np.median(errors):.1e}",
        f"{np.mean(errors > 1e-6):.1%}",
    ]


def compare(case: Case, points: Points, tolerance: float) -> list[str]:
    """Print the methods side by side; returns how many times less CPU time ecfit takes."""
    ours, note = by_ecfit(case, points, tolerance)
    rows = [row(f"dblquad, {order}", values, case.exact) for order, values in case.paper.items()]
    rows.append(row(f"ecfit, tolerance {tolerance:.0e}", ours, case.exact))
    size = " x ".join(map(str, points.grid.shape))
    show(
        f"{case.title}, {size} table; errors on {points.index.size} random entries",
        ["method", "CPU ms/entry", "+-", "max error", "median", "> 1e-6"],
        rows,
    )
    print(f"  ecfit: {note}")
    return [case.title, *(f"{values.cpu.mean() / ours.cpu.mean():.0f}" for values in case.paper.values())]


def grid(count: Sequence[int], F0: tuple[float, float], mu: tuple[float, float]) -> Grid:
    """The paper's axes with other numbers of nodes."""
    f0_count, r_count, mu_count = count
    return Grid(
        (
            ecfit.Axis.spaced("F0", f0_count, *F0, "uniform"),
            ecfit.Axis.spaced("r", r_count, 0.035, 1.0, "clamped"),
            ecfit.Axis.spaced("mu", mu_count, *mu, "clamped"),
        )
    )


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--count", type=int, nargs=3, metavar=("F0", "R", "MU"), help="nodes (32 64 64)")
    parser.add_argument("--sample", type=int, help="entries computed by the paper's method (100)")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="of ecfit's tables (1e-6)")
    given = parser.parse_args()
    count = given.count or ([4, 8, 8] if given.quick else [32, 64, 64])
    sample = given.sample or (10 if given.quick else 100)

    points = Points.of(grid(count, (0.0, 1.0), (0.02, 1.0)), sample)
    ratios = [compare(glossy(points), points, given.tolerance)]
    points = Points.of(grid(count, (0.0125, 0.25), (0.02, 0.98)), sample)
    for side in SIDES:
        ratios += [compare(case, points, given.tolerance) for case in dielectrics(points, side)]
    show(
        "CPU time an entry: how many times less by ecfit than by",
        ["", *(f"dblquad, {order}" for order in paper_method.ORDERS)],
        ratios,
    )
    print(f"\n  peak resident memory: {common.peak_memory():.0f} MB")


if __name__ == "__main__":
    main()
