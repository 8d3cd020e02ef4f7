"""Fits as source code: written, and checked by compilers and devices."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def export(
    fit: str,
    *,
    lang: str,
    name: str | None = None,
    output: Path | None = None,
    coordinates: str = "",
    clamp: bool = False,
    factor: bool = False,
    least: float | None = None,
    derivative: str = "",
) -> None:
    """Write a fit as source code of a language, with its contract in a comment.

    Parameters
    ----------
    fit
        A published or shipped fit by name (`ecfit list` shows them), a fit's JSON file, or a table (NPZ).
    lang
        glsl, hlsl, wgsl, msl, slang, osl, c, cpp, python, or materialx: a library of several files.
    name
        Of the function; by default the fit's.
    output
        File to write, folder for materialx; without, the code is printed.
    coordinates
        Views that it takes, separated by commas: r or alpha, F0 or ior. By default those of the fit.
    clamp
        Clamp the arguments to the domain.
    factor
        Also a function for 1 / E, and for conductors one for 1 + F0 (1 / E - 1) with a colour F0.
    least
        E is raised to this where 1 / E is meant; 1/32 by default.
    derivative
        Also a function for the slope by this argument.
    """
    from ecfit.export import Options, source, write

    views = tuple(v.strip() for v in coordinates.split(",") if v.strip())
    approximation, evidence = source(fit)
    given = {} if least is None else {"least": least}
    options = Options(name, views, clamp, factor, derivative=derivative, evidence=evidence, **given)
    print(write(approximation, lang, options, output))


def check_export(
    *fits: str,
    tool: Annotated[
        tuple[str, ...], Parameter(help="Tool to use; repeatable. By default all there are.")
    ] = (),
    points: int = 4096,
) -> None:
    """Compile and run exported code with the compilers and devices of this machine, and compare with NumPy.

    Exit code 1 where a value is not finite, or farther from the exact one than twice NumPy's float32, and
    where a tool that --tool asks for is not there.

    Parameters
    ----------
    fits
        Names of fits or their JSON files; by default all shipped fits.
    points
        How many in the closed domain of each, corners and edges included.
    """
    from ecfit.approximation import find, shipped
    from ecfit.shaders import TOOLS, check_all
    from ecfit.shaders import tool as named

    found = [find(fit) for fit in dict.fromkeys(fits or shipped())]
    tools = [named(t) for t in dict.fromkeys(tool)] or list(TOOLS.values())
    failed = False
    for report in check_all(found, tools, points, asked=bool(tool)):
        print(report.describe(), flush=True)
        failed |= not report.passes
    if failed:
        raise SystemExit(1)
