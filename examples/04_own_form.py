"""A form of your own, in five lines of Equinox: whatever is differentiable in JAX can be fitted.

    python examples/04_own_form.py
    python examples/04_own_form.py --output figures

A rough metal loses energy in proportion to alpha, roughly, and less at grazing angles than seen from above;
what counts as grazing is mu against alpha. `Blend` says just that in three numbers: the loss is c0 alpha at
mu = 0, tends to c1 alpha for mu >> alpha, and c2 says how soon. Its array holds the coefficients, its
values are the start; `ecfit.fit` does the rest by Levenberg-Marquardt with derivatives from JAX. A plane (a
polynomial of degree 1) has three numbers too, and errs twice as much.

The decorator gives the form a name. With it a config can ask for it (`form = "module"`, `module = "blend"`)
and a file can hold its fit: the name and three numbers, never code.

Printed: both fits with their errors, the fitted module, and what comes back from a file. With --output also
`04-blend.png`: both forms against the table as slices.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import cyclopts
import equinox
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt

import ecfit
from ecfit.report import plot_slice


@ecfit.register_form("blend")
class Blend(equinox.Module):
    c: jax.Array = equinox.field(default=(0.4, 0.6, 4.0), converter=jnp.asarray)

    def __call__(self, mu: jax.Array, alpha: jax.Array) -> jax.Array:
        return 1.0 - alpha * (self.c[0] * alpha + self.c[1] * self.c[2] * mu) / (alpha + self.c[2] * mu)


class Found(NamedTuple):
    """What the example found, for who imports it."""

    table: ecfit.Table
    ours: ecfit.Fit
    plane: ecfit.Fit
    again: ecfit.Fit


def main(*, nodes: int = 32, output: Path | None = None) -> Found:
    """Fit an own form beside a polynomial with as many coefficients.

    Parameters
    ----------
    nodes
        Of the table, along r and along mu.
    output
        Folder for the figure; without it none is drawn.
    """
    # The table is one over r; the form asks for alpha, and gets r^2. At alpha = mu = 0 its quotient is 0 / 0:
    # the table begins above.
    r = ecfit.Axis.spaced("r", nodes, 0.035, 1.0)
    table = ecfit.tabulate("conductor", {"r": r, "mu": nodes})

    # Where c2 is positive, so is the divisor. That is for us to see: of a module nobody else knows its poles.
    ours, plane = ecfit.fit(table, Blend()), ecfit.fit(table, ecfit.Polynomial(1))
    print(plane, ours, sep="\n\n", end="\n\n")
    print(f"the fitted module: {ours.module}, c = {ours.coefficients.round(4)}")

    with TemporaryDirectory() as folder:
        ours.save(Path(folder) / "blend.json")
        again = ecfit.Fit.load(Path(folder) / "blend.json")
    print(f"from a file: {again}")

    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
        plot_slice(table, ours, plane, axes=axes)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
        figure.savefig(output / "04-blend.png", dpi=150)
        print(f"written: {output / '04-blend.png'}")
    return Found(table, ours, plane, again)


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
