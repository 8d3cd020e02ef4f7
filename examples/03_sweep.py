"""A sweep: a TOML file crosses tables with forms and degrees, and Python goes on with the results.

    python examples/03_sweep.py
    python examples/03_sweep.py --config configs/quick.toml --output figures

A study is a file and not a script, so that it can be kept, compared and run again; what is there is not
done again. The file here is `sweep.toml` beside this one. This page reads it before anything is computed,
runs it, and then reads `summary.csv`, one row a fit, as any other program would. From the command line it
is

    ecfit run examples/sweep.toml

Printed: what the file asks for, the verdict for each table, and the summary: RMS error by degree, with what
is published beside it. The results, with the report as a page, go to a temporary folder, or to that of
--output; there `03-sweep.png` is drawn as well: RMS error against degree.
"""

import csv
from pathlib import Path
from tempfile import mkdtemp
from typing import NamedTuple

import cyclopts
import matplotlib.pyplot as plt

import ecfit
from ecfit.config import read_config

HERE = Path(__file__).parent


class Found(NamedTuple):
    """What the example found, for who imports it."""

    study: ecfit.Study
    rows: list[dict[str, str]]


def main(*, config: Path = HERE / "sweep.toml", output: Path | None = None) -> Found:
    """Run a study and read its summary.

    Parameters
    ----------
    config
        The study file.
    output
        Folder for the results and the figure; without it the results go to a temporary one, and no figure is
        drawn.
    """
    asked = read_config(config)  # typed and checked: a mistake is told with its line
    degrees = sum(len(fits.degree) if isinstance(fits.degree, list) else 1 for fits in asked.fits)
    print(f"{asked.name}: {len(asked.tables)} tables, {degrees} forms")

    study = ecfit.run(config, output or mkdtemp(prefix="ecfit-"))
    with (study.folder / "summary.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    print(study, end="\n\n")

    print(f"{'table':<12} {'form':<32} {'degree':>6} {'numbers':>7} {'RMSE':>9} {'largest':>9}  status")
    for row in rows:
        print(
            f"{row['table']:<12} {row['form']:<32} {row['degree']:>6} {row['coefficients']:>7} "
            f"{float(row['rmse']):9.2e} {float(row['max_error']):9.2e}  {row['status']}"
        )

    if output is not None:
        _draw(study, rows, output / "03-sweep.png")
    return Found(study, rows)


def _draw(study: ecfit.Study, rows: list[dict[str, str]], path: Path) -> None:
    """RMS error against degree, from the summary alone: a panel a table, a line a family."""
    figure, panels = plt.subplots(
        1, len(study.tables), figsize=(4.5 * len(study.tables), 3.6), sharey=True, squeeze=False,
        layout="constrained",
    )  # fmt: skip
    for axes, table in zip(panels[0], study.tables, strict=True):
        for form, marker in (("polynomial", "o"), ("rational", "s")):
            found = [r for r in rows if r["table"] == table and r["form"] == form]
            line = axes.plot(
                [int(r["degree"]) for r in found], [float(r["rmse"]) for r in found], marker, linestyle="-",
                label=form,
            )  # fmt: skip
            for r in found:  # what it takes to store
                axes.annotate(
                    r["coefficients"], (int(r["degree"]), float(r["rmse"])), (4, 4), fontsize=7,
                    textcoords="offset points", color=line[0].get_color(),
                )  # fmt: skip
        for row in rows:
            if row["table"] == table and row["status"].startswith("published"):
                axes.axhline(float(row["rmse"]), color="black", linestyle=":", label=row["form"])
        axes.set(title=table, xlabel="degree (beside the points: numbers to store)", yscale="log")
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.legend(frameon=False, fontsize=8)
    panels[0][0].set_ylabel("RMS error")
    figure.savefig(path, dpi=150)
    print(f"written: {path}")


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
