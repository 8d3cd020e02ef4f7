"""Fit a shipped model: from a BSDF to a formula with a known error, in four calls.

    python examples/01_fit_a_model.py
    python examples/01_fit_a_model.py --output figures

A renderer that adds the energy which a rough metal loses between its facets needs the directional albedo
E(r, mu) of the white metal at every shading point. `tabulate` integrates it, with an error estimate for
every entry; `fit` looks for the best rational of a degree; and the errors are measured on a table that the
fit has never seen, finer and at other nodes.

Printed: the table, the fit with its errors, the errors on the finer table, one value of the formula beside
the integral, and the formula as code. With --output also `01-fit.png`: E and its fit as slices, the signed
error as an image.
"""

from pathlib import Path
from typing import NamedTuple

import cyclopts
import matplotlib.pyplot as plt

import ecfit
from ecfit.metrics import Errors, measure
from ecfit.report import plot_error, plot_slice


class Found(NamedTuple):
    """What the example found, for who imports it."""

    table: ecfit.Table
    fit: ecfit.Fit
    unseen: Errors


def main(*, nodes: int = 32, degree: int = 3, output: Path | None = None) -> Found:
    """Tabulate and fit the white conductor.

    Parameters
    ----------
    nodes
        Of the table, along r and along mu.
    degree
        Of the rational's numerator and denominator.
    output
        Folder for the figure; without it none is drawn.
    """
    # GGX, separable masking, F = 1. The axes are r = sqrt(alpha) and mu = cos(theta), both over [0, 1].
    table = ecfit.tabulate("conductor", {"r": nodes, "mu": nodes})
    print(table, end="\n\n")

    fit = ecfit.fit(table, ecfit.Rational(degree))
    print(fit, end="\n\n")  # its errors on the table's own nodes, and whether it has a pole

    # Texel centres lie between the nodes above, and there are more of them: nothing here was fitted.
    between = {name: ecfit.Axis.spaced(name, 2 * nodes, spacing="texel-centre") for name in ("r", "mu")}
    unseen = measure(fit.approximation, ecfit.tabulate("conductor", between))
    print(f"where it was not fitted: RMSE {unseen.rmse:.4e}, largest error {unseen.max_error:.4e}")

    r, mu = 0.5, 0.3
    integral = ecfit.directional_albedo("conductor", r=r, mu=mu)
    print(f"at r = {r}, mu = {mu}: the fit says {fit(r=r, mu=mu):.5f}, the integral {integral:.5f}\n")
    print(fit.to_code("glsl"))

    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
        plot_slice(table, fit, axes=left)
        plot_error(fit, table, axes=right)
        figure.savefig(output / "01-fit.png", dpi=150)
        print(f"written: {output / '01-fit.png'}")
    return Found(table, fit, unseen)


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
