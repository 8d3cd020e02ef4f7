"""Time and true error of a table: the method of Sforza & Pellacini 2022 against ecfit, in one run.

    pip install -e '.[bench]'
    python benchmarks/tables.py            # 1024 x 1024 entries, about a minute and a half
    python benchmarks/tables.py --quick    # small, to see that it works

A random sample of the table's entries is computed by the paper's method; ecfit computes the whole table.
True errors are against an adaptive integral that uses none of ecfit's code (benchmarks/reference.py).
"""

from typing import NamedTuple

import common
import jax
import numpy as np
import paper_method
import reference
from common import show, timed

import ecfit
from ecfit.quantities import DirectionalAlbedo

Array = np.ndarray

SEED = 20220701
# The default, and one that puts ecfit's errors below those of the paper's method.
TOLERANCES = (1e-7, 1e-10)
LEVELS = range(5)


class Points(NamedTuple):
    """Points with their albedo by the reference."""

    r: Array
    mu: Array
    exact: Array

    @classmethod
    def at(cls, r: Array, mu: Array) -> "Points":
        exact = [reference.albedo(float(m), float(a)) for m, a in zip(mu, r, strict=True)]
        return cls(r, mu, np.array(exact))


class Result(NamedTuple):
    """One way to fill the table: seconds an entry, and errors of the sample."""

    name: str
    cpu: float
    wall: float
    errors: Array
    note: str

    def row(self) -> list[str]:
        return [
            self.name,
            f"{1e3 * self.cpu:.4g}",
            f"{1.0 / self.wall:.0f}",
            f"{self.errors.max():.1e}",
            f"{np.median(self.errors):.1e}",
        ]


def by_paper(points: Points, order: str) -> Result:
    """The sample by the paper's method."""
    pairs = [(float(m), float(r)) for m, r in zip(points.mu, points.r, strict=True)]
    paper_method.albedo(0.5, 0.5, order)  # warm-up
    values, times = zip(*(timed(lambda p=p: paper_method.albedo(*p, order)) for p in pairs), strict=True)
    cpu = np.array([t.cpu for t in times])
    spread = 1e3 * cpu.std(ddof=1) / np.sqrt(cpu.size)
    return Result(
        f"dblquad, {order}",
        float(cpu.mean()),
        float(np.mean([t.wall for t in times])),
        np.abs(np.array(values) - points.exact),
        f"{1e3 * cpu.mean():.3g} +- {spread:.2g} ms CPU an entry (mean and its standard error)",
    )


def by_ecfit(points: Points, index: Array, count: int, tolerance: float) -> Result:
    """The whole table by ecfit; errors on the sample with the flat indices `index`."""
    _, cold = timed(lambda: common.clamped_table(count, tolerance))
    table, warm = timed(lambda: common.clamped_table(count, tolerance))
    errors = np.abs(table.values.ravel()[index] - points.exact)
    estimates = table.errors.ravel()[index]
    size = table.values.size
    return Result(
        f"ecfit, tolerance {tolerance:.0e}",
        warm.cpu / size,
        warm.wall / size,
        errors,
        f"{warm.wall:.1f} s wall, {warm.cpu:.1f} s CPU "
        f"({cold.wall:.1f} s, {cold.cpu:.1f} s with compilation); "
        f"error above its estimate in {np.mean(errors > estimates):.1%} of the sample",
    )


def compare(points: Points, index: Array, count: int) -> None:
    """Print the methods side by side, and how many times faster ecfit is."""
    paper = [by_paper(points, order) for order in paper_method.ORDERS]
    before = common.peak_memory()
    ours = [by_ecfit(points, index, count, tolerance) for tolerance in TOLERANCES]
    show(
        f"Conductor, {count} x {count} clamped table; errors on {index.size} random entries",
        ["method", "CPU ms/entry", "entries/s", "max error", "median"],
        [result.row() for result in (*paper, *ours)],
    )
    show(
        "CPU time an entry: how many times less by",
        ["", *(p.name for p in paper)],
        [[o.name, *(f"{p.cpu / o.cpu:.0f}" for p in paper)] for o in ours],
    )
    print()
    for result in (*paper, *ours):
        print(f"  {result.name}: {result.note}")
    after = common.peak_memory()
    print(f"  peak resident memory: {after:.0f} MB, {before:.0f} MB of it before ecfit's first table")


def level_row(points: Points, level: int) -> list[str]:
    """Errors of one level of the half-vector rule."""
    quantity, model = DirectionalAlbedo(), ecfit.model("conductor")

    @jax.jit
    @jax.vmap
    def estimate(r: jax.Array, mu: jax.Array):
        return quantity.estimate(model.with_parameters({"alpha": r * r}), mu, level)

    value, estimated = map(np.asarray, estimate(points.r, points.mu))
    errors = np.abs(value - points.exact)
    return [
        str(level),
        str(quantity.nodes(model)[level]),
        f"{errors.max():.1e}",
        f"{np.median(errors):.1e}",
        f"{estimated.max():.1e}",
        f"{np.median(estimated):.1e}",
    ]


def show_levels(title: str, points: Points) -> None:
    """Print the errors of all levels."""
    header = ["level", "nodes", "max error", "median", "max estimate", "median"]
    show(f"Half-vector rule, {title}", header, [level_row(points, level) for level in LEVELS])


def open_domain(count: int, rng: np.random.Generator) -> Points:
    """Log-uniform points of r in [1e-2, 1], mu in [1e-3, 1]."""
    r, mu = (10.0 ** rng.uniform(exponent, 0.0, count) for exponent in (-2.0, -3.0))
    return Points.at(r, mu)


def main() -> None:
    quick = common.wants_quick(__doc__)
    count, sampled = (128, 20) if quick else (1024, 200)
    rng = np.random.default_rng(SEED)
    index = rng.choice(count * count, sampled, replace=False)
    nodes = common.clamped_grid(count).nodes_at(index)
    points = Points.at(nodes["r"], nodes["mu"])
    compare(points, index, count)
    show_levels(f"{sampled} entries of the clamped table", points)
    show_levels(
        f"{sampled} points, log-uniform in r in [1e-2, 1], mu in [1e-3, 1]", open_domain(sampled, rng)
    )


if __name__ == "__main__":
    main()
