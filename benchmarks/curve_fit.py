"""Time, memory and error of rational fits of degree 3: SciPy's `curve_fit` against ecfit, in one run.

    pip install -e '.[bench]'
    python benchmarks/curve_fit.py            # 1024 x 1024 and 128 x 128 x 128: some 20 minutes, 5 GB
    python benchmarks/curve_fit.py --quick    # 64 x 64 and 16 x 16 x 16

The tables of Sforza & Pellacini 2022: the conductor on clamped axes (19 coefficients), and light entering a
dielectric in radiance transport (39 coefficients). All methods see the same table; errors are of all its
entries. Each row is measured in a fresh process with one thread: its peak of memory is its own, and CPU time
is what it takes on an idle machine.

- `curve_fit` is given the whole table, as in the paper: from all ones, derivatives by finite differences,
  monomials computed once. "lm" is its default (MINPACK), "trf" its other method.
- `ecfit.fit` is what a user calls: descents from several starts on a few weighted nodes, the last on
  128 nodes an axis in two dimensions and 32 in three, then a proof that the denominator has no zero and the
  errors on the whole table. "Cold" is the first fit of a process, with compilation, "warm" the second.
- "One descent" is the part of it that does what `curve_fit` does: one start (the linearised fit), one
  Levenberg-Marquardt descent on the same weighted nodes.
"""

import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import common
import numpy as np
from common import Timing, alone, peak_memory, timed

import ecfit
from ecfit.coordinates import Grid

Array = np.ndarray
DEGREE = 3


class Result(NamedTuple):
    """One fit: how long it took and how good it is on the whole table."""

    method: str
    timing: Timing
    rmse: float
    mae: float
    memory: float
    note: str


def errors(fitted: Array, table: ecfit.Table) -> tuple[float, float]:
    """RMSE and MAE over all entries."""
    e = np.abs(fitted.ravel() - table.values.ravel())
    return float(np.sqrt(np.mean(e * e))), float(e.mean())


def by_curve_fit(path: Path, method: str, most: int) -> list[Result]:
    """`curve_fit` on all entries; coordinates are mapped to [0, 1], as the paper does with F0."""
    import paper_method

    table = ecfit.Table.load(path)
    nodes = table.grid.nominal_at(np.arange(table.values.size))
    scaled = [(nodes[a.name] - a.low) / (a.high - a.low) for a in table.axes]
    found, timing = timed(lambda: paper_method.fit(scaled, table.values.ravel(), method, most, DEGREE))
    note = f"{found.evaluations} evaluations" + ("" if found.ended else f", stopped after {most} Jacobians")
    return [Result(f"`curve_fit`, {method}", timing, *errors(found.values, table), peak_memory(), note)]


def by_ecfit(path: Path) -> list[Result]:
    """`ecfit.fit`, twice, with all that it checks."""
    table = ecfit.Table.load(path)
    out = []
    for name in ("cold", "warm"):
        found, timing = timed(lambda: ecfit.fit(table, ecfit.Rational(degree=DEGREE)))
        note = f"{found.status}, {found.iterations} steps"
        out.append(Result(f"`ecfit.fit`, {name}", timing, found.rmse, found.mae, peak_memory(), note))
    return out


def by_one_descent(path: Path) -> list[Result]:
    """One start and one descent, twice: the coefficients, without any check."""
    from ecfit.fitting.fit import _FINAL_RTOL, _POLISH_NODES
    from ecfit.fitting.problem import Problem
    from ecfit.fitting.solver import solve
    from ecfit.fitting.start import polynomial_start, sanathanan_koerner

    table = ecfit.Table.load(path)

    def descend() -> tuple[Problem, Any]:
        whole = Problem.of_table(table, ecfit.Rational(degree=DEGREE).terms(len(table.axes)))
        few = whole.thinned(_POLISH_NODES[len(table.axes)])
        start = (sanathanan_koerner(few) or [polynomial_start(few)])[0]
        return whole, solve(few, start, rtol=_FINAL_RTOL, max_steps=1000)

    out = []
    for name in ("cold", "warm"):
        (whole, found), timing = timed(descend)
        numerator = whole.on_grid(found.p, whole.terms.numerator)
        denominator = found.q[0] + whole.on_grid(found.q[1:], whole.terms.denominator)
        note = f"{found.steps} steps" + ("" if found.converged else ", not converged")
        measured = errors(numerator / denominator, table)
        out.append(Result(f"one descent of ecfit, {name}", timing, *measured, peak_memory(), note))
    return out


def dielectric_table(count: int) -> ecfit.Table:
    """The paper's table of light entering a dielectric: R + T in radiance transport."""
    grid = Grid(
        (
            ecfit.Axis.spaced("F0", count, 0.0125, 0.25),
            ecfit.Axis.spaced("r", count, 0.035, 1.0, "clamped"),
            ecfit.Axis.spaced("mu", count, 0.02, 0.98, "clamped"),
        )
    )
    model = ecfit.model("dielectric", side="entering", masking="separable")
    return ecfit.tabulate(model, {a.name: a for a in grid.axes}, transport="radiance", tolerance=1e-6)


def compare(title: str, table: ecfit.Table, most: int) -> None:
    """Fit one table by all methods and print a Markdown table."""
    size = " x ".join(map(str, table.grid.shape))
    count = ecfit.Rational(degree=DEGREE).count(len(table.axes))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.npz"
        table.save(path)
        ours = [*alone(by_ecfit, path), *alone(by_one_descent, path)]
        theirs = [r for method in ("lm", "trf") for r in alone(by_curve_fit, path, method, most)]
    fastest = min(r.timing.cpu for r in theirs)
    print(f"\n{title}, {size}, {count} coefficients; CPU time against the faster `curve_fit`\n")
    header = ["method", "wall s", "CPU s", "times faster", "RMSE", "MAE", "peak MB", ""]
    rows = [
        [
            r.method,
            *(f"{s:.3g}" for s in r.timing),
            f"{fastest / r.timing.cpu:.3g}",
            f"{r.rmse:.6e}",
            f"{r.mae:.4e}",
            f"{r.memory:.0f}",
            r.note,
        ]
        for r in (*theirs, *ours)
    ]
    print(common.markdown(header, rows), flush=True)


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--most", type=int, default=100, help="Jacobians of `curve_fit` at most (100)")
    given = parser.parse_args()
    flat, solid = (64, 16) if given.quick else (1024, 128)
    compare("Conductor, clamped", common.clamped_table(flat), given.most)
    compare("Dielectric, entering, radiance", dielectric_table(solid), given.most)


if __name__ == "__main__":
    main()
