"""How long a user waits: for help, for a file to start from, for a study with and without compiled code.

    python benchmarks/start.py            # some minutes
    python benchmarks/start.py --quick    # commands without a study: seconds
    python benchmarks/start.py --write    # puts the table into docs/performance.md

Every run is a new process of this Python, in a temporary folder with results of its own. Python's own files
are compiled (a run that is not counted sees to it) and in memory; what XLA compiles is kept as a row says.
"""

import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import common

from ecfit._cache import SWITCH
from ecfit.errors import EcfitError
from ecfit.starter import configs

# Runs of a command that takes a moment, and of a study that takes many.
OFTEN, SELDOM = 7, 3
# Commands that need no numbers.
COMMANDS = (("--help",), ("--version",), ("run", "--help"), ("list",))
STUDIES = ("quick", "starter")
HEADER = ("command", "compiled code", "runs", "least s", "median s", "CPU s")


class Waited(NamedTuple):
    """Seconds of one run: elapsed, and of all its processes' processors together."""

    wall: float
    cpu: float


class Row(NamedTuple):
    """A command, what the folder of compiled code held before, and its runs."""

    command: str
    compiled: str
    runs: list[Waited]

    def cells(self) -> tuple[str, ...]:
        walls = [run.wall for run in self.runs]
        cpu = statistics.median(run.cpu for run in self.runs)
        seconds = (min(walls), statistics.median(walls), cpu)
        return (f"`{self.command}`", self.compiled, str(len(walls)), *(f"{s:.3g}" for s in seconds))


def waited(words: Sequence[str], folder: Path, cache: Path | str = "off") -> Waited:
    """One run of `ecfit words` in a folder; raises `EcfitError` where it fails."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "ecfit", *words],
        cwd=folder,
        env={**os.environ, SWITCH: str(cache)},
        capture_output=True,
        text=True,
    )
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise EcfitError(f"ecfit {' '.join(words)} failed: {done.stderr.strip()}")
    return Waited(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def commands(folder: Path, times: int) -> list[Row]:
    """Help and what else needs no numbers, and `init`, which may not find its file."""
    rows = []
    for words in COMMANDS:
        waited(words, folder)
        rows.append(Row(f"ecfit {' '.join(words)}", "", [waited(words, folder) for _ in range(times)]))
    runs = [waited(("init", f"s{n}.toml"), folder) for n in range(times)]
    return [*rows, Row("ecfit init", "", runs)]


def study(name: str, folder: Path, times: int) -> list[Row]:
    """`ecfit run` of a study that comes with ecfit: no folder of compiled code, an empty and a filled one.

    Results are new each time, so that nothing is found of an earlier run but compiled code.
    """
    taken = ("init", f"{name}.toml", "--like", name)
    waited(taken, folder)

    def once(label: str, cache: Path | str) -> Waited:
        results = folder / f"{name}-{label}"
        run = waited(("run", f"{name}.toml", "--results", str(results)), folder, cache)
        if not (results / name / "report.html").is_file():
            raise EcfitError(f"ecfit run {name}.toml wrote no report")
        return run

    caches = [folder / f"cache-{name}-{n}" for n in range(times)]
    off = [once(f"off-{n}", "off") for n in range(times)]
    empty = [once(f"empty-{n}", cache) for n, cache in enumerate(caches)]
    filled = [once(f"filled-{n}", cache) for n, cache in enumerate(caches)]
    label = f"ecfit run {name}.toml"
    return [Row(label, "not kept", off), Row(label, "kept, none yet", empty), Row(label, "found", filled)]


def saving(rows: Sequence[Row]) -> str:
    """One sentence a study: what the kept code saves, and what keeping it costs the first run."""
    said = []
    for command in dict.fromkeys(row.command for row in rows if row.compiled):
        off, empty, filled = (
            statistics.median(run.wall for run in row.runs) for row in rows if row.command == command
        )
        more = f"{abs(empty - off):.1f} s {'longer' if empty >= off else 'shorter'}"
        said.append(
            f"- `{command}`: code that is found saves {off - filled:.1f} s ({1 - filled / off:.0%}); "
            f"keeping it makes the first run {more}."
        )
    return "\n".join(said)


def machine() -> str:
    """Where this was measured."""
    from importlib.metadata import version

    return (
        f"{os.cpu_count()} processors ({platform.machine()}), load {os.getloadavg()[0]:.1f} before, "
        f"Python {platform.python_version()}, JAX {version('jax')}."
    )


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/performance.md")
    parser.add_argument("--runs", type=int, default=SELDOM, help=f"of each study; {SELDOM} by default")
    given = parser.parse_args()
    if given.runs < 1:
        raise EcfitError("--runs must be 1 or more")
    where = machine()
    missing = [name for name in STUDIES if name not in configs()]
    if missing:
        raise EcfitError(f"no study {', '.join(missing)} comes with this ecfit")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        rows = commands(folder, OFTEN)
        common.show("Commands", HEADER, [row.cells() for row in rows])
        if not given.quick:
            for name in STUDIES:
                found = study(name, folder, given.runs)
                common.show(name, HEADER, [row.cells() for row in found])
                rows += found
            print(f"\n{saving(rows)}")
    if given.write:
        table = common.markdown(HEADER, [row.cells() for row in rows])
        text = f"{table}\n\n{where}\n\n{saving(rows)}"
        common.replace_between(common.DOCS / "performance.md", "start.py", start=text)


if __name__ == "__main__":
    try:
        main()
    except EcfitError as error:
        sys.exit(f"error: {error}")
