"""What fitting on a thinned table costs in error: RMSE on all nodes, before and after a descent on all.

    python benchmarks/thinning.py        # a few minutes, 2 GB

`ecfit.fit` fits large tables on a part of their nodes that is weighted to stand for all
(`ecfit.fitting.problem`). Here the descent goes on from there on all nodes, of the clamped conductor
(1024 x 1024) and of a dielectric in energy transport (96 x 96 x 96).
"""

import common
from common import show

import ecfit
from ecfit.fitting import Fitter
from ecfit.fitting.problem import Problem
from ecfit.fitting.solver import mean_square, solve

# Steps on all rows: enough to see how much there is to gain.
_STEPS = 12


def excess(name: str, table: ecfit.Table, degrees: tuple[int, ...]) -> list[list[str]]:
    """One row a degree: what a descent on all rows still gains over the fit."""
    fitter = Fitter(table)
    rows = []
    for degree in degrees:
        form = ecfit.Rational(degree)
        thinned, solution, _, _ = fitter.descend(form)
        whole = Problem.of_table(table, form.terms(len(table.axes)))
        before = mean_square(whole, solution.p, solution.q) ** 0.5
        after = solve(whole, (solution.p, solution.q), rtol=1e-6, max_steps=_STEPS).sum_of_squares ** 0.5
        gain = f"{100.0 * (before / after - 1.0):.4f} %"
        rows.append([name, str(degree), str(thinned.rows), f"{before:.6e}", f"{after:.6e}", gain])
    return rows


def main() -> None:
    axes = {
        "F0": ecfit.Axis.spaced("F0", 96, 0.0125, 0.25),
        "r": ecfit.Axis.spaced("r", 96, 0.03, 1.0),
        "mu": ecfit.Axis.spaced("mu", 96, 0.02, 1.0),
    }
    rows = excess("conductor", common.clamped_table(1024), (3, 5, 7))
    rows += excess("dielectric, entering", ecfit.tabulate("dielectric", axes, tolerance=1e-6), (2, 3, 4))
    header = ["table", "degree", "rows", "RMSE of ecfit.fit", "RMSE, all rows", "excess"]
    show("Rational fits on weighted nodes", header, rows)


if __name__ == "__main__":
    main()
