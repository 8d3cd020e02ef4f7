"""Time and error of the rational fit of degree 3: Sforza & Pellacini 2022 against ecfit, in one run.

    pip install -e '.[bench]'
    python benchmarks/fits.py            # tables of 64 x 64 and 1024 x 1024, about a minute
    python benchmarks/fits.py --quick    # 64 x 64 only

Both fit the same table. ecfit's first fit of each size includes compilation ("cold"); SciPy compiles nothing.
The peak of resident memory is that of the process so far.
"""

from typing import NamedTuple

import common
import numpy as np
import paper_method
from common import Timing, show, timed

import ecfit


class Result(NamedTuple):
    """One fit: how long it took and how good it is."""

    name: str
    timing: Timing
    rmse: float
    mae: float
    max_error: float
    peak_memory: float
    note: str = ""

    def row(self) -> list[str]:
        numbers = (f"{v:.4e}" for v in (self.rmse, self.mae, self.max_error))
        seconds = (f"{v:.3f}" for v in self.timing)
        return [self.name, *seconds, *numbers, f"{self.peak_memory:.0f}"]


def by_paper(table: ecfit.Table) -> Result:
    """`curve_fit` on the nominal coordinates."""
    nodes = table.grid.nominal_at(np.arange(table.values.size))
    values = table.values.ravel()
    fitted, timing = timed(lambda: paper_method.fit(nodes["r"], nodes["mu"], values))
    e = np.abs(fitted - values)
    rmse, mae, largest = float(np.sqrt(np.mean(e * e))), float(e.mean()), float(e.max())
    return Result("curve_fit from ones", timing, rmse, mae, largest, common.peak_memory())


def by_ecfit(table: ecfit.Table, name: str) -> Result:
    """`ecfit.fit`, with all that it checks."""
    found, timing = timed(lambda: ecfit.fit(table, ecfit.Rational(degree=3)))
    memory = common.peak_memory()
    note = f"{found.status} in {found.iterations} iterations"
    return Result(f"ecfit, {name}", timing, found.rmse, found.mae, found.max_error, memory, note)


def compare(count: int) -> None:
    """Fit one table by both methods and print the outcome."""
    table = common.clamped_table(count)
    # curve_fit last: its peak of memory would hide ecfit's.
    ours = [by_ecfit(table, name) for name in ("cold", "warm")]
    paper = by_paper(table)
    show(
        f"Rational of degree 3 on the {count} x {count} clamped conductor table",
        ["method", "wall s", "CPU s", "RMSE", "MAE", "max error", "peak MB"],
        [result.row() for result in (*ours, paper)],
    )
    warm = ours[-1]
    wall, cpu = paper.timing.wall / warm.timing.wall, paper.timing.cpu / warm.timing.cpu
    print(f"  time of curve_fit / time of ecfit, warm: {wall:.3g} (wall), {cpu:.3g} (CPU); ecfit {warm.note}")


def main() -> None:
    for count in (64,) if common.wants_quick(__doc__) else (64, 1024):
        compare(count)


if __name__ == "__main__":
    main()
