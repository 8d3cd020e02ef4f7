"""What benchmarks/scaling.py measures. Each function runs in a process of its own, with one thread."""

import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from common import Timing, peak_memory, timed

import ecfit
from ecfit.study.runner import Progress
from ecfit.tables import Request

# Runs shorter than this are repeated: the shorter time counts, as noise only adds.
_SHORT = 1.0


class Subject(NamedTuple):
    """A kind of table: a model with its options, and what is integrated to which tolerance."""

    title: str
    model: str
    tolerance: float
    lobe: str = "all"

    def request(self, shape: Sequence[int], tolerance: float | None = None) -> Request:
        """The table over (r, mu) or (F0, r, mu)."""
        axes: dict[str, object] = dict(zip(("r", "mu"), shape[-2:], strict=True))
        if len(shape) == 3:
            axes = {"F0": ecfit.Axis.spaced("F0", shape[0], 0.0125, 0.25), **axes}
        return Request.make(self.model, axes, lobe=self.lobe, tolerance=tolerance or self.tolerance)


class Run(NamedTuple):
    """A table: its entries, BSDF values an entry, and the processor's seconds warm and at first."""

    entries: int
    nodes: float
    warm: float
    cold: float


def _best(function: Callable[[], object]) -> float:
    """CPU seconds of a call; the shorter of two where it is short."""
    seconds = timed(function)[1].cpu
    return min(seconds, timed(function)[1].cpu) if seconds < _SHORT else seconds


def _nodes(request: Request) -> float:
    """BSDF values an entry, on average: a row climbs all levels up to the last."""
    ended: list[int] = []
    request.compute(ended.append)  # told once a level, and once more of what never ends
    levels = request.quantity.nodes(request.model)
    climbed = [sum(levels[: i + 1]) for i in range(len(levels))]
    total = sum(n * climbed[min(i, len(levels) - 1)] for i, n in enumerate(ended))
    return total / request.grid.size


def tables(subject: Subject, shapes: Sequence[Sequence[int]]) -> list[Run]:
    """Tables of growing size; the first compiles for all, apart from blocks of sizes of their own."""
    return [_run(subject.request(shape)) for shape in shapes]


def _run(request: Request) -> Run:
    nodes, cold = timed(lambda: _nodes(request))
    return Run(request.grid.size, nodes, _best(request.compute), cold.cpu)


def tolerances(subject: Subject, shape: Sequence[int], wanted: Sequence[float]) -> list[Run]:
    """One table to finer and finer tolerances."""
    return [_run(subject.request(shape, tolerance)) for tolerance in wanted]


def memory(kind: str, counts: Sequence[int]) -> list[tuple[int, float]]:
    """(entries, MB above the process before) of tables of growing size: `MEMORY` says which."""
    build = MEMORY[kind]
    build(counts[0] // 10).compute()
    before, found = peak_memory(), []
    for count in counts:
        request = build(count)
        request.compute()
        found.append((request.grid.size, peak_memory() - before))
    return found


def _fresnel(iors: int, entries: int) -> Request:
    """F(mu) of a dielectric, one evaluation an entry: what is left is the memory of the entries."""
    axes = {"ior": ecfit.Axis.spaced("ior", iors, 1.0, 2.0), "mu": max(2, entries // iors)}
    return Request.make("dielectric", axes, "fresnel")


def _long(entries: int) -> Request:
    """Two geometries for all entries, with 768 nodes at the coarsest level."""
    model = ecfit.model("conductor", fresnel="schlick", alpha=0.4)
    return Request.make(model, {"F0": max(2, entries // 2), "mu": [0.3, 0.7]}, tolerance=1e-4)


MEMORY: dict[str, Callable[[int], Request]] = {
    "rows of 100 entries that share their geometry": lambda n: _fresnel(100, n),
    "rows of 2 entries": lambda n: _fresnel(2, n),
    "two rows, whatever their length": _long,
    "conductor, all levels": lambda n: Subject("", "conductor", 1e-7).request([round(n**0.5)] * 2),
}


class FitRun(NamedTuple):
    """A fit: its sizes, what it did, CPU seconds warm and at first, and the peak of memory in MB."""

    form: str
    entries: int
    coefficients: int
    starts: int
    steps: int
    warm: float
    cold: float
    memory: float


def fits(subject: Subject, shape: Sequence[int], degrees: Sequence[int]) -> list[FitRun]:
    """Rational fits of growing degree, each by `ecfit.fit` alone, which tries the smaller ones first."""
    table = subject.request(shape).compute()
    runs = []
    for degree in degrees:
        form = ecfit.Rational(degree)
        _, cold = timed(lambda f=form: ecfit.fit(table, f))
        found, warm = timed(lambda f=form: ecfit.fit(table, f))
        name = f"rational, degree {degree}"
        count = found.approximation.count
        sizes = (table.values.size, count, found.starts, found.iterations)
        runs.append(FitRun(name, *sizes, warm.cpu, cold.cpu, peak_memory()))
    return runs


class StepRun(NamedTuple):
    """One step of a descent: residuals, coefficients, CPU seconds."""

    residuals: int
    coefficients: int
    seconds: float


def steps(sizes: Sequence[int], degrees: Sequence[int], few: int, many: int) -> list[StepRun]:
    """Seconds of one Levenberg-Marquardt step: what `many` steps take more than `few`."""
    from ecfit.fitting.problem import Problem
    from ecfit.fitting.solver import solve
    from ecfit.fitting.start import polynomial_start

    runs = []
    for size in sizes:
        table = Subject("", "conductor", 1e-4).request([size, size]).compute()
        for degree in degrees:
            form = ecfit.Rational(degree)
            problem = Problem.of_table(table, form.terms(2))
            start = polynomial_start(problem)

            def descend(most: int, p: Problem = problem, s: tuple = start) -> tuple[int, float]:
                # No tolerance: it ends by the number of its steps.
                found, timing = timed(lambda: solve(p, s, rtol=1e-300, max_steps=most))
                return found.steps, timing.cpu

            descend(few)
            short, long = (min((descend(n) for _ in range(3)), key=lambda r: r[1]) for n in (few, many))
            if long[0] > short[0]:
                seconds = (long[1] - short[1]) / (long[0] - short[0])
                runs.append(StepRun(problem.rows, form.count(2), seconds))
    return runs


class _Watch(Progress):
    """Wall seconds of each stage of a run."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        started = time.perf_counter()
        yield lambda steps: None
        self.seconds[title] = time.perf_counter() - started


def sweep(count: int, workers: int, degree: int, size: int) -> float:
    """Wall seconds of `count` equal fits (one table each) of a study by so many workers, imports included."""
    names = [f"t{i}" for i in range(count)]
    table = f'model = "conductor"\naxes = {{ r = {size}, mu = {size} }}\n'
    text = 'name = "sweep"\n' + "".join(f'[[tables]]\nname = "{name}"\n{table}' for name in names)
    text += f'[[fits]]\ntables = {names}\nform = "rational"\ndegree = [{degree}]\n[report]\nfigures = []\n'
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder) / "sweep.toml"
        config.write_text(text)
        watch = _Watch()
        ecfit.run(config, Path(folder) / "results", workers=workers, progress=watch)
    return watch.seconds["fits"]


def table_once_more(subject: Subject, shape: Sequence[int]) -> Timing:
    """Times of a table that is compiled, on what devices and threads this process has."""
    request = subject.request(shape)
    request.compute()
    return timed(request.compute)[1]
