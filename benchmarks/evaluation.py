"""Nanoseconds an evaluation in compiled C: every shipped fit, published formulas and tables, in one run.

    python benchmarks/evaluation.py            # about a minute; needs a C compiler (cc, or $CC)
    python benchmarks/evaluation.py --quick    # shorter measurements
    python benchmarks/evaluation.py --write    # puts the table into docs/performance.md

Each approximation becomes a C loop over arrays of points in float32 (benchmarks/c_source.py), compiled with
-O3 -ffast-math, with and without -march=native. Tables are read linearly, in random order, from float32
arrays that stay in the caches as nothing else wants them, those of more than 32 KB in the second level. Their
nodes are uniform in the coordinates that are given, or in roots of them (mu = t^2; F0 = t^2 or t^4). Every
compiled function is checked against ecfit's value at the same points.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import c_source
import common
import numpy as np

import ecfit
from ecfit.approximation import Approximation, Lookup, published_names
from ecfit.certify.truth import Sampling
from ecfit.errors import EcfitError
from ecfit.export.compilers import CC
from ecfit.expressions import cost, value

Array = np.ndarray

# Arrays of three inputs and an output stay within a second-level cache of 512 KB and more.
POINTS = 16_384
# Nodes an axis of the tables; the middle one is what the others are compared with.
TABLES = (16, 32, 64)
# Spacings of (r), (r, mu), (F0, r, mu) as roots of the coordinates: uniform, or mu = t^2, F0 = t^2 or t^4.
SPACINGS = ((0,), (0, 0), (0, 1), (0, 0, 0), (1, 0, 1), (2, 0, 1))
_THROUGH = ("identity", "square", "fourth-power")
# In float32, allowed is this or a few times what NumPy's float32 arithmetic loses, where that is more.
LARGEST_DIFFERENCE, _TIMES = 1e-5, 4.0
# The same text in double differs from NumPy's by rounding only, relative to 1 + |value|.
_ROUNDING = 1e-9
_FLAGS, _FAST = ("-std=gnu11", "-shared", "-fPIC"), ("-O3", "-ffast-math")


class Timed(NamedTuple):
    """One row: what is stored and computed, nanoseconds an evaluation with and without -march=native, and the
    largest difference from the value in float64."""

    name: str
    variables: int
    numbers: int
    operations: str
    native: float
    portable: float
    lost: float


class Subject(NamedTuple):
    """What is compiled: a kernel, its inputs in float32, the values that it should give, and how near."""

    name: str
    variables: int
    numbers: int
    operations: str
    source: Callable[[str], str]
    inputs: list[Array]
    expected: Array
    allowed: float


def compiler() -> list[str] | None:
    """The C compiler's command, or None where there is none."""
    return CC.command()


def of_formula(approximation: Approximation) -> Subject:
    """A formula at random points of its domain."""
    expression, variables = approximation.expression(), approximation.variables
    drawn = Sampling(POINTS).points(approximation)
    inputs = [np.ascontiguousarray(drawn[v], dtype=np.float32) for v in variables]
    exact = value(expression, {v: x.astype(np.float64) for v, x in zip(variables, inputs, strict=True)})
    single = value(expression, dict(zip(variables, inputs, strict=True)))
    lost = float(np.max(np.abs(single - exact)))
    return Subject(
        approximation.name,
        len(variables),
        approximation.count,
        str(cost(expression)),
        lambda name: c_source.of_expression(name, expression, variables),
        inputs,
        exact,
        max(LARGEST_DIFFERENCE, _TIMES * lost),
    )


def of_table(count: int, roots: tuple[int, ...]) -> Subject:
    """A table of random numbers, read at random places."""
    rng = np.random.default_rng(count)
    variables = len(roots)
    shape = (count,) * variables
    table = 0.5 * rng.random(shape, dtype=np.float32)
    points = [rng.random(POINTS, dtype=np.float32) for _ in shape]
    through = tuple(_THROUGH[n] for n in roots)
    expected = Lookup(table, ((0.0, 1.0),) * variables, through).value([p.astype(np.float64) for p in points])
    corners = 2**variables
    return Subject(
        table_name(count, roots),
        variables,
        table.size,
        f"{corners} reads from {table.nbytes / 1024:.4g} KB, {corners - 1} interpolations{_roots(roots)}",
        lambda name: c_source.of_table(name, shape, roots),
        [*points, table.ravel()],
        np.asarray(expected),
        LARGEST_DIFFERENCE,
    )


def table_name(count: int, roots: tuple[int, ...]) -> str:
    """ "table 32^2", and how many roots the spacing of the nodes takes: "table 32^3, 3 roots"."""
    power = f"^{len(roots)}" if len(roots) > 1 else ""
    return f"table {count}{power}{_roots(roots)}"


def _roots(roots: tuple[int, ...]) -> str:
    return {0: "", 1: ", 1 root"}.get(sum(roots), f", {sum(roots)} roots")


@contextmanager
def library(subjects: list[Subject], flags: tuple[str, ...]) -> Iterator[ctypes.CDLL]:
    """All kernels compiled together. Raises `EcfitError` where the compiler fails."""
    text = c_source.HEADER + "".join(s.source(f"k{i}") for i, s in enumerate(subjects))
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "kernels.c", Path(folder) / "kernels.so"
        source.write_text(text)
        command = [*(compiler() or ["cc"]), *_FLAGS, *flags, "-o", str(target), str(source), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise EcfitError(f"{' '.join(command[:1])} failed: {done.stderr.strip().splitlines()[0]}; set CC")
        yield ctypes.CDLL(str(target))


class Call:
    """A compiled kernel with its inputs."""

    def __init__(self, kernels: ctypes.CDLL, name: str, subject: Subject, kind: type = np.float32) -> None:
        number = ctypes.c_float if kind is np.float32 else ctypes.c_double
        pointer = ctypes.POINTER(number)
        self.out = np.empty(POINTS, dtype=kind)
        self._kept = [x.astype(kind) for x in subject.inputs]
        inputs = (pointer * len(self._kept))(*(x.ctypes.data_as(pointer) for x in self._kept))
        self._arguments = inputs, self.out.ctypes.data_as(pointer), POINTS
        self._run = getattr(kernels, name)

    def values(self) -> Array:
        self._run(*self._arguments, 1)
        return self.out

    def seconds(self, passes: int) -> float:
        start = time.process_time()
        self._run(*self._arguments, passes)
        return time.process_time() - start


def check(subjects: list[Subject]) -> None:
    """Raise `EcfitError` where the C text, computed in double, is not ecfit's value."""
    with library(subjects, ("-O1", "-DREAL=double")) as kernels:
        for i, subject in enumerate(subjects):
            found = Call(kernels, f"k{i}", subject, np.float64).values()
            difference = np.abs(found - subject.expected) / (1.0 + np.abs(subject.expected))
            _refuse(subject, float(np.max(difference)), _ROUNDING, "in double")


def _refuse(subject: Subject, difference: float, allowed: float, how: str) -> None:
    if not difference < allowed:
        raise EcfitError(
            f"{subject.name}: the C text {how} differs from the Python value by {difference:.2g}, allowed "
            f"are {allowed:.2g}: mend benchmarks/c_source.py"
        )


def nanoseconds(calls: list[Call], rounds: int, seconds: float) -> list[float]:
    """The least time of several rounds, an evaluation; a round measures all calls, one after the other."""
    passes = []
    for call in calls:
        count = 1
        while call.seconds(count) < seconds / 4.0:
            count *= 2
        passes.append(4 * count)
    measured = [[c.seconds(p) / p for c, p in zip(calls, passes, strict=True)] for _ in range(rounds)]
    return [min(times) / POINTS * 1e9 for times in zip(*measured, strict=True)]


def measure(approximations: list[Approximation], quick: bool = False) -> list[Timed]:
    """All approximations that have an expression, and tables of one to three variables.

    Raises `EcfitError` where there is no compiler and where a compiled function is wrong.
    """
    if compiler() is None:
        raise EcfitError("no C compiler: install cc, or set CC; nothing was measured")
    subjects = [of_formula(a) for a in approximations]
    subjects += [of_table(count, roots) for roots in SPACINGS for count in TABLES]
    rounds, seconds = (3, 2e-3) if quick else (30, 5e-3)
    check(subjects)
    times: list[list[float]] = []
    lost: list[float] = []
    for flags in (_FAST, ("-march=native", *_FAST)):
        with library(subjects, flags) as kernels:
            calls = [Call(kernels, f"k{i}", s) for i, s in enumerate(subjects)]
            lost = [
                float(np.max(np.abs(c.values() - s.expected))) for c, s in zip(calls, subjects, strict=True)
            ]
            for subject, difference in zip(subjects, lost, strict=True):
                _refuse(subject, difference, subject.allowed, "in float32")
            times.append(nanoseconds(calls, rounds, seconds))
    portable, native = times
    return [
        Timed(s.name, s.variables, s.numbers, s.operations, *measured)
        for s, *measured in zip(subjects, native, portable, lost, strict=True)
    ]


def formulas() -> list[Approximation]:
    """All shipped fits, then all published formulas that have an expression."""
    found = [ecfit.shipped(name) for name in ecfit.shipped()]
    for name in published_names():
        approximation = ecfit.published(name)
        try:
            approximation.expression()
        except EcfitError:  # a table
            continue
        found.append(approximation)
    return found


def printed(rows: list[Timed]) -> str:
    """Rows as Markdown, those of equal numbers of variables together."""
    reference = {v: t for t in rows for v in (1, 2, 3) if t.name == table_name(TABLES[1], (0,) * v)}
    header = ["name", "numbers", "operations", "ns", "ns, portable", "look-up = 1", "float32 error"]
    out = []
    for variables, look in reference.items():
        out += [
            [
                t.name,
                str(t.numbers),
                t.operations,
                f"{t.native:.2f}",
                f"{t.portable:.2f}",
                f"{t.native / look.native:.2f}",
                f"{t.lost:.1e}",
            ]
            for t in rows
            if t.variables == variables
        ]
    return common.markdown(header, out)


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    given = parser.parse_args()
    if compiler() is None:
        print("no C compiler: install cc, or set CC; nothing was measured", file=sys.stderr)
        return
    table = printed(measure(formulas(), given.quick))
    print(table)
    if given.write:
        common.replace_between(common.DOCS / "performance.md", "evaluation.py", evaluation=table)


if __name__ == "__main__":
    main()
