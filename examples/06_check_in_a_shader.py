"""Export a fit, compile it, run it, and compare with Python: is the code what the fit is?

    python examples/06_check_in_a_shader.py
    python examples/06_check_in_a_shader.py --output code \
        --fit conductor-10 --fit results/quick/fits/conductor-rational-3.json

What a renderer compiles is text, in single precision, with the digits that were printed. The errors of a
fit are those of Python in double. Between the two stands a compiler; so it is asked. `ecfit.shaders` writes
the same expression in the language of every tool that it finds here (a C compiler, OpenGL on the processor
or a GPU, WebGPU, Slang, ...), runs it at points of the closed domain, corners and edges first, and compares
the values with those of NumPy in single precision, in units in the last place, and with the exact ones.

Nothing has to be installed for this page: what is missing is said, with what to install. From the command
line:

    ecfit check-export conductor-10

Printed: the GLSL of the fit, a line for each tool, and the verdict. With --output the code is kept there, a
file for each fit, in GLSL and C.
"""

from pathlib import Path
from typing import NamedTuple

import cyclopts

import ecfit
from ecfit.approximation import find
from ecfit.shaders import Report, check_all, tool

FIT = "conductor-10"
TRIED = ("cc", "opengl", "glslang", "webgpu", "slang")


class Found(NamedTuple):
    """What the example found, for who imports it."""

    approximations: list[ecfit.Approximation]
    reports: list[Report]


def main(*, fit: tuple[str, ...] = (FIT,), tools: tuple[str, ...] = TRIED, points: int = 4096,
         output: Path | None = None) -> Found:  # fmt: skip
    """Export fits and compare what compilers make of them with Python.

    Parameters
    ----------
    fit
        Names of shipped or published fits, or JSON files of fits.
    tools
        To compile with: names of `ecfit.shaders.TOOLS`.
    points
        Of the domain of each fit.
    output
        Folder for the code; without it nothing is written.
    """
    approximations = [find(name) for name in fit]
    print(approximations[0].to_code("glsl"))

    reports = []
    for report in check_all(approximations, [tool(name) for name in tools], points):
        print(report.describe())
        reports.append(report)

    outcomes = [report.outcome for report in reports if report.outcome is not None]
    wrong = [report.tool.name for report in reports if not report.passes]
    if wrong:
        print(f"\nNOT THE SAME: {', '.join(wrong)}")
    elif outcomes:
        worst = max((a.worst for outcome in outcomes for a in outcome.agreements), default=0.0)
        print(f"\nas in Python on {len(outcomes)} of {len(reports)} tools, to {worst:.3g} ulps")
    else:
        print(f"\nnothing to compare with: none of {', '.join(tools)} is here")

    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        for approximation in approximations:
            for language in ("glsl", "c"):
                path = output / f"{approximation.name}.{language}"
                path.write_text(approximation.to_code(language), encoding="utf-8")
                print(f"written: {path}")
    return Found(approximations, reports)


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
