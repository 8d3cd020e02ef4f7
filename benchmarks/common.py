"""What the benchmarks share: the paper's table, stop-watches and printing. Import it before NumPy."""

import argparse
import os
import resource
import sys
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

# One thread for the small, tall matrices of least squares: with more, OpenBLAS spends more time on
# synchronisation than on arithmetic as soon as anything else runs. Read when NumPy and SciPy are loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import ecfit
from ecfit.coordinates import Grid

T = TypeVar("T")


class Timing(NamedTuple):
    """Seconds: elapsed, and of the processor summed over all threads."""

    wall: float
    cpu: float


def timed(function: Callable[[], T]) -> tuple[T, Timing]:
    """The result of a call and the time that it took."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = function()
    return result, Timing(time.perf_counter() - wall, time.process_time() - cpu)


def peak_memory() -> float:
    """Largest resident size of this process so far, in MB."""
    unit = 1.0 if sys.platform == "darwin" else 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


def clamped_grid(count: int) -> Grid:
    """The axes of Sforza & Pellacini 2022, `count` nodes each."""
    r = ecfit.Axis.spaced("r", count, 0.035, 1.0, "clamped")
    mu = ecfit.Axis.spaced("mu", count, 0.02, 1.0, "clamped")
    return Grid((r, mu))


def clamped_table(count: int, tolerance: float = 1e-7) -> ecfit.Table:
    """The conductor's table on those axes."""
    axes = {axis.name: axis for axis in clamped_grid(count).axes}
    return ecfit.tabulate("conductor", axes, tolerance=tolerance)


def arguments(description: str | None) -> argparse.ArgumentParser:
    """A command line with --quick."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="small tables and samples: seconds, no figures")
    return parser


def wants_quick(description: str | None) -> bool:
    """Whether the command line says --quick."""
    return arguments(description).parse_args().quick


def show(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    print(f"\n{title}")
    for row in (header, ["-" * w for w in widths], *rows):
        first, *rest = (
            cell.rjust(w) if i else cell.ljust(w) for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        print("  ".join(["", first, *rest]), flush=True)


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    rules = ["-" * w if i == 0 else "-" * (w - 1) + ":" for i, w in enumerate(widths)]
    lines = []
    for row in (header, rules, *rows):
        cells = [c.rjust(w) if i else c.ljust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
