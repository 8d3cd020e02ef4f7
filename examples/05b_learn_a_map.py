"""Learn the coordinates of a fit together with its coefficients.

    python examples/05b_learn_a_map.py
    python examples/05b_learn_a_map.py --degree 3 --output figures

Whether a rational should be one in r, in alpha = r^2, or in something between is mostly a habit. It can be
learned: `learned-rational` is P / Q in r^p and mu^q, whose exponents p and q descend together with the
coefficients, from the plain rational at p = q = 1. The exponents are numbers to store like the others; so
the fair comparison is not with the plain rational, but with one that keeps r and mu as they are and spends
the two numbers on two more terms: the best that `ecfit.Selected` finds among all terms of one degree more.

At degree 2 and 3 the learned map has the smaller RMS error of the two, at degree 1 the larger one:
`--degree 1`. What this does not show: a power is dearer than a multiplication, the search for terms proves
nothing, and forms of another structure are better than either (docs/choosing-a-fit.md).

Printed: the plain rational, the learned one with its exponents, and the fixed one of as many numbers. With
--output also `05b-map.png`: the three errors along r and along mu.
"""

from pathlib import Path
from typing import NamedTuple

import cyclopts
import matplotlib.pyplot as plt

import ecfit
from ecfit.forms import ModuleForm
from ecfit.report import plot_error_along


class Found(NamedTuple):
    """What the example found, for who imports it."""

    plain: ecfit.Fit
    learned: ecfit.Fit
    fixed: ecfit.Fit
    exponents: dict[str, float]


def main(*, nodes: int = 32, degree: int = 2, output: Path | None = None) -> Found:
    """Fit a rational, one with learned exponents, and one of as many numbers with fixed ones.

    Parameters
    ----------
    nodes
        Of the table, along r and along mu.
    degree
        Of the rational's numerator and denominator.
    output
        Folder for the figure; without it none is drawn.
    """
    r = ecfit.Axis.spaced("r", nodes, 0.035, 1.0)
    mu = ecfit.Axis.spaced("mu", nodes, 0.02, 1.0)
    table = ecfit.tabulate("conductor", {"r": r, "mu": mu})

    plain = ecfit.fit(table, ecfit.Rational(degree), name="plain")
    learned = ecfit.fit(table, ModuleForm("learned-rational", {"degree": degree}), name="learned map")
    terms = {"highest": {"r": degree + 1, "mu": degree + 1}, "total": degree + 1}
    as_many = ecfit.Selected("ratio", ("r", "mu"), [terms], terms, budget=learned.coefficients.size)
    fixed = ecfit.fit(table, as_many, name="fixed map, more terms")

    # Exponents come first among the module's arrays.
    exponents = dict(zip(learned.approximation.variables, learned.coefficients.tolist(), strict=False))
    for fit in (plain, learned, fixed):
        print(fit, end="\n\n")
    print("learned: " + ", ".join(f"{name}^{power:.3f}" for name, power in exponents.items()))
    print(f"RMSE of {fixed.coefficients.size} numbers: learned {learned.rmse:.2e}, fixed {fixed.rmse:.2e}")

    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.6), sharey=True, layout="constrained")
        for axes, name in zip(panels, ("r", "mu"), strict=True):
            plot_error_along([plain, learned, fixed], table, name, axes=axes)
        figure.savefig(output / "05b-map.png", dpi=150)
        print(f"written: {output / '05b-map.png'}")
    return Found(plain, learned, fixed, exponents)


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
