"""The cost model: time and memory of tables and fits against their sizes, and what 1e9 or 1e6 of them take.

    python benchmarks/scaling.py                     # some 5 minutes of CPU
    python benchmarks/scaling.py --quick             # small, to see that it works
    python benchmarks/scaling.py --write             # puts the results into docs/scaling.md
    python benchmarks/scaling.py --workers [--write] # only workers and devices: on two idle cores

Each part is measured in a fresh process with one thread. Seconds are those of the processor, so that other
work on the machine matters little; those of workers are of the clock. "Deviation" is the largest
|measured / law - 1|. Memory is the peak of the resident size above that before the first table of the kind.
"""

from collections.abc import Iterator

import common
import scaling_measures as measures
from common import alone
from scaling_laws import Law, line, power
from scaling_measures import FitRun, Run, StepRun, Subject

DOCUMENT = common.DOCS / "scaling.md"
SCRIPT = "scaling.py"

CONDUCTOR = Subject("conductor, E", "conductor", 1e-7)
DIELECTRIC = Subject("dielectric, R + T, 8 F0 a row", "dielectric", 1e-6)
BURLEY = Subject("burley, a rule for any BSDF", "burley", 1e-4)

# Values, errors and status of an entry on disk: two doubles and a byte.
STORED = 17
CORES = (1, 16, 256, 4096)


def seconds(value: float) -> str:
    """A time in its best unit."""
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0), ("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def shapes(subject: Subject, quick: bool) -> list[tuple[int, ...]]:
    """Sizes of tables; blocks of the dielectric have one size, so that only its first table compiles."""
    if subject is DIELECTRIC:
        return [(8, n, n) for n in ((6, 12) if quick else (12, 24, 48))]
    return [
        (n, n) for n in ((16, 32) if quick else (32, 64, 128, 256) if subject is CONDUCTOR else (32, 64, 128))
    ]


def tables(quick: bool) -> tuple[str, dict[str, tuple[Law, float]]]:
    """Time against entries; by subject the law, and what the first table of a process takes more."""
    rows, laws = [], {}
    for subject in (CONDUCTOR, DIELECTRIC, BURLEY):
        runs: list[Run] = alone(measures.tables, subject, shapes(subject, quick))
        law = line([r.entries for r in runs], [r.warm for r in runs])
        first = runs[0].cold - runs[0].warm
        laws[subject.title] = law, first
        fixed, slope = law.coefficients
        rows.append(
            [
                subject.title,
                f"{subject.tolerance:.0e}",
                ", ".join(f"{r.entries}: {seconds(r.warm)}" for r in runs),
                f"{runs[-1].nodes:.0f}",
                seconds(fixed),
                seconds(slope),
                law.quality(),
                seconds(first),
            ]
        )
    header = [
        "table",
        "tolerance",
        "entries: CPU time",
        "values an entry",
        "a",
        "b",
        "deviation, R2",
        "at first",
    ]
    return common.markdown(header, rows), laws


def tolerances(quick: bool) -> str:
    """Time against tolerance: it is the number of BSDF values that counts."""
    wanted = (1e-4, 1e-7) if quick else (1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
    runs: list[Run] = alone(measures.tolerances, CONDUCTOR, (32, 32) if quick else (96, 96), wanted)
    rows = [
        [
            f"{tolerance:.0e}",
            f"{r.nodes:.0f}",
            seconds(r.warm / r.entries),
            seconds(r.warm / r.entries / r.nodes),
        ]
        for tolerance, r in zip(wanted, runs, strict=True)
    ]
    law = line([r.nodes for r in runs], [r.warm / r.entries for r in runs])
    fixed, slope = law.coefficients
    table = common.markdown(["tolerance", "BSDF values an entry", "time an entry", "a value"], rows)
    said = f"An entry takes {seconds(fixed)} + {seconds(slope)} x its values"
    return f"{table}\n\n{said} (deviation, R2: {law.quality()})."


def memory(quick: bool) -> str:
    """Memory against entries."""
    rows = []
    for kind in measures.MEMORY:
        counts = [10_000, 100_000] if quick else [1_000_000, 4_000_000, 16_000_000]
        if kind.startswith("two rows"):
            counts = [2_000, 8_000] if quick else [5_000, 20_000, 80_000]
        if kind.startswith("conductor"):
            counts = [1024, 4096] if quick else [4096, 16384, 65536]
        runs: list[tuple[int, float]] = alone(measures.memory, kind, counts)
        (first, least), (last, most) = runs[-2:]
        slope = 1e6 * (most - least) / (last - first)
        rows.append([kind, ", ".join(f"{n}: {mb:.0f}" for n, mb in runs), f"{slope:.0f}"])
    return common.markdown(["table", "entries: MB above the process", "bytes an entry more"], rows)


def steps(quick: bool) -> str:
    """Time of a step of a descent against residuals and coefficients."""
    sizes, degrees = ((16, 32), (1, 2)) if quick else ((32, 64, 128), (2, 3, 5))
    runs: list[StepRun] = alone(measures.steps, sizes, degrees, 5, 105)
    counts = sorted({r.coefficients for r in runs})
    residuals = sorted({r.residuals for r in runs})
    rows, lines = [], []
    for count in counts:
        own = [r for r in runs if r.coefficients == count]
        lines.append(line([r.residuals for r in own], [r.seconds for r in own]))
        by_size = {r.residuals: seconds(r.seconds) for r in own}
        fixed, slope = lines[-1].coefficients
        rows.append(
            [
                str(count),
                *(by_size.get(n, "") for n in residuals),
                seconds(fixed),
                seconds(slope),
                lines[-1].quality(),
            ]
        )
    header = ["coefficients", *(f"{n} residuals" for n in residuals), "a", "b", "deviation, R2"]
    said = []
    for name, part in zip("ab", zip(*(law.coefficients for law in lines), strict=True), strict=True):
        if min(part) > 0.0:  # else lost in the noise
            law = power(part, counts)
            factor, exponent = law.coefficients
            said.append(f"{name} = {seconds(factor)} x coefficients^{exponent:.2f} ({law.quality()})")
    return f"{common.markdown(header, rows)}\n\nOver the rows of this table: {', '.join(said)}."


def fits(quick: bool) -> tuple[str, dict[str, FitRun]]:
    """Whole fits; by title those that the arithmetic goes on with."""
    flat, solid = ((24, 24), (4, 8, 8)) if quick else ((64, 64), (16, 16, 16))
    cases = [
        ("conductor", CONDUCTOR, flat, (1, 2) if quick else (1, 2, 3, 4)),
        ("conductor", CONDUCTOR, (48, 48) if quick else (256, 256), (2,) if quick else (3,)),
        ("dielectric", DIELECTRIC, solid, (1,) if quick else (1, 2, 3)),
    ]
    rows, notes, kept = [], [], {}
    for title, subject, shape, degrees in cases:
        runs: list[FitRun] = alone(measures.fits, subject, shape, degrees)
        size = " x ".join(map(str, shape))
        rows += [
            [
                f"{title}, {size}",
                str(r.coefficients),
                str(r.starts),
                str(r.steps),
                seconds(r.warm),
                seconds(r.warm / r.starts),
                seconds(r.cold),
                f"{r.memory:.0f}",
            ]
            for r in runs
        ]
        for r in runs:
            kept[f"{title}, {size}, {r.coefficients} coefficients"] = r
        if len(runs) > 2:
            law = power([r.warm for r in runs], [r.coefficients for r in runs])
            factor, exponent = law.coefficients
            notes.append(
                f"{title}, {size}: {seconds(factor)} x coefficients^{exponent:.2f} "
                f"(deviation, R2: {law.quality()})"
            )
    header = ["table", "coefficients", "starts", "steps", "warm", "a start", "first", "peak MB"]
    laws = "".join(f"\n- {note}" for note in notes)
    return f"{common.markdown(header, rows)}\n\nTime of a warm fit:\n{laws}", kept


def arithmetic(laws: dict[str, tuple[Law, float]], runs: dict[str, FitRun]) -> str:
    """What 1e9 entries and 1e6 fits take: work over cores, and the start of each process once."""
    rows = []

    def add(what: str, count: float, each: float, start: float) -> None:
        work = count * each
        rows.append(
            [
                what,
                seconds(each),
                seconds(start),
                f"{work / 3600.0:,.1f}",
                *(seconds(work / cores + start) for cores in CORES),
            ]
        )

    for title, (law, start) in laws.items():
        add(f"1e9 entries, {title}", 1e9, law.coefficients[1], start)
    wanted = [name for name in runs if runs[name].coefficients in (19, 39)] or list(runs)
    for name in wanted:
        run = runs[name]
        add(f"1e6 fits, {name}", 1e6, run.warm, run.cold - run.warm)
    header = [
        "work",
        "each",
        "start of a process",
        "core hours",
        *(f"{n} cores" if n > 1 else "1 core" for n in CORES),
    ]
    stored = 1e9 * STORED / 1e9
    return (
        f"{common.markdown(header, rows)}\n\n"
        "Time on N cores = number x each / N + start, each core with a process of its own. "
        f"1e9 entries are 1e9 x {STORED} bytes = {stored:.0f} GB on disk."
    )


def workers(quick: bool) -> str:
    """Equal fits by one and by two workers, and a table on one device and on two. Seconds of the clock."""
    counts, degree, size = ((2, 4), 1, 16) if quick else ((8, 32), 3, 64)
    # Two threads here: one worker is then a process of its own too.
    two = {"PJRT_NPROC": "2"}
    found = {
        (n, w): alone(measures.sweep, n, w, degree, size, environment=two) for n in counts for w in (1, 2)
    }
    rows = []
    for n in counts:
        t1, t2 = found[n, 1], found[n, 2]
        rows.append([f"{n} fits", seconds(t1), seconds(t2), f"{t1 / (2.0 * t2):.0%}"])
    # Without the start of the processes, which every worker has once.
    each = {w: (found[counts[1], w] - found[counts[0], w]) / (counts[1] - counts[0]) for w in (1, 2)}
    rows.append(["a fit more", seconds(each[1]), seconds(each[2]), f"{each[1] / (2.0 * each[2]):.0%}"])
    form = f"rational fits of degree {degree} to {size} x {size} entries"
    header = [f"sweep of equal {form}", "1 worker", "2 workers", "efficiency"]
    shape = (32, 32) if quick else (512, 512)
    flags = "--xla_force_host_platform_device_count=2"
    cases = {
        "1 device, 1 thread": {},
        "1 device, 2 threads": two,
        "2 devices": {**two, "XLA_FLAGS": flags},
    }
    times = {
        name: alone(measures.table_once_more, CONDUCTOR, shape, environment=setting)
        for name, setting in cases.items()
    }
    on = [[name, seconds(t.wall), seconds(t.cpu)] for name, t in times.items()]
    devices = common.markdown([f"conductor, {shape[0]} x {shape[1]} entries", "wall", "CPU"], on)
    return f"{common.markdown(header, rows)}\n\nEfficiency is t1 / (2 t2).\n\n{devices}"


def measured(quick: bool) -> Iterator[tuple[str, str]]:
    """Marker and Markdown of all parts but the workers, as they are measured."""
    by_entries, laws = tables(quick)
    yield "tables", by_entries
    yield "tolerances", tolerances(quick)
    yield "memory", memory(quick)
    yield "steps", steps(quick)
    whole, runs = fits(quick)
    yield "fits", whole
    yield "arithmetic", arithmetic(laws, runs)


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--workers", action="store_true", help="measure workers and devices, nothing else")
    parser.add_argument("--write", action="store_true", help="put the results into docs/scaling.md")
    given = parser.parse_args()
    for name, part in [("workers", workers(given.quick))] if given.workers else measured(given.quick):
        print(f"\n## {name}\n\n{part}", flush=True)
        if given.write:
            common.replace_between(DOCUMENT, SCRIPT, **{name: part})


if __name__ == "__main__":
    main()
