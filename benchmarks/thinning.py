"""What fitting on a thinned table costs in error: RMSE on all nodes, before and after a descent on all.

    python benchmarks/thinning.py        # a few minutes

`ecfit.fit` fits large tables on a part of their nodes that is weighted to stand for all
(`ecfit.fitting.problem`). Here the descent goes on from there on all nodes of the
clamped 1024 x 1024 conductor table.
"""

import common
from common import show

import ecfit
from ecfit.fitting import Fitter
from ecfit.fitting.problem import Problem
from ecfit.fitting.solver import mean_square, solve


def main() -> None:
    table = common.clamped_table(1024)
    fitter = Fitter(table)
    rows = []
    for degree in (3, 5, 7):
        form = ecfit.Rational(degree)
        thinned, solution, _, _ = fitter.descend(form)
        whole = Problem.of_table(table, form.terms(2))
        before = mean_square(whole, solution.p, solution.q) ** 0.5
        after = solve(whole, (solution.p, solution.q), rtol=1e-6, max_steps=12).sum_of_squares ** 0.5
        excess = f"{100.0 * (before / after - 1.0):.4f} %"
        rows.append([str(degree), str(thinned.rows), f"{before:.6e}", f"{after:.6e}", excess])
    header = ["degree", "rows", "RMSE of ecfit.fit", "RMSE, all rows", "excess"]
    show("Rational fits of the clamped 1024 x 1024 conductor", header, rows)


if __name__ == "__main__":
    main()
