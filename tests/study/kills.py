"""A script: runs of one study that are killed at random moments, or side by side, and what they leave.

    kills.py FOLDER COUNT SEED

Prints one JSON line. Each run is a fork of a process that has imported everything but computed nothing: a
fork after JAX has run would hang, and a fresh process for each would spend its life importing.
"""

import json
import os
import random
import sys
import time
import warnings
from pathlib import Path

from ecfit._cache import SWITCH, keep_compiled

if __name__ == "__main__":
    os.environ[SWITCH] = str(Path(sys.argv[1]) / "cache")
    keep_compiled()  # before JAX loads: most of a run would be compiling

from ecfit.study import runner
from ecfit.tables import Table

CONFIG = """
name = "small"
[[tables]]
name = "e"
file = "e.csv"
axes = { r = 8, mu = 8 }
[[tables]]
name = "f"
file = "f.csv"
axes = { r = 8, mu = 8 }
[[fits]]
tables = ["e", "f"]
form = "polynomial"
degree = [1, 2, 3]
[report]
figures = []
"""


def written(folder: Path) -> Path:
    for name, power in (("e", 1), ("f", 2)):
        rows = [[1.0 - 0.4 * (i / 7) ** power * (1.0 - j / 9) for j in range(8)] for i in range(8)]
        (folder / f"{name}.csv").write_text("\n".join(",".join(map(repr, row)) for row in rows))
    (folder / "study.toml").write_text(CONFIG)
    return folder / "study.toml"


def begun(config: Path, results: Path) -> int:
    """The process id of a run."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            # Pages take most of the time, and are written by the same function as all else.
            import ecfit.report

            ecfit.report.write_report = lambda study: None
            runner.run(config, results, workers=1)
            code = 0
        finally:
            os._exit(code)
    return child


def ended(child: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def files(results: Path) -> dict[str, object]:
    """The finished files: their bytes, or what a table holds (an archive has dates)."""
    found: dict[str, object] = {}
    for path in sorted(results.rglob("*")):
        if path.is_file() and not path.name.endswith(".part") and path.name != "timings.csv":
            name = str(path.relative_to(results))
            found[name] = Table.load(path).digest if path.suffix == ".npz" else path.read_bytes()
    return found


def main(folder: Path, count: int, seed: int) -> dict[str, object]:
    warnings.simplefilter("ignore")  # Python and JAX warn of forks
    config, draw = written(folder), random.Random(seed)
    started = time.monotonic()
    assert ended(begun(config, folder / "whole")) == 0
    whole, duration = files(folder / "whole"), time.monotonic() - started
    results, before = folder / "killed", {}
    faults: list[str] = []
    rounds = finished = kept = 0
    killed = 0
    while killed < count:
        child = begun(config, results)
        # Most of a run is what comes before its first file.
        time.sleep(duration * draw.uniform(0.3, 1.1))
        os.kill(child, 9)
        code = ended(child)
        killed += code == -9
        now = files(results)
        faults += [f"{name} is lost" for name in before if name not in now]
        faults += [f"{name} is not what it should be" for name in now if now[name] != whole.get(name)]
        kept += len(now)
        before = now
        if code == 0:
            finished += 1
        if len(now) == len(whole):
            rounds += 1
            results, before = folder / f"killed{rounds}", {}
    assert ended(begun(config, results)) == 0
    if files(results) != whole:
        faults.append("the last run did not finish what the killed ones left")
    pair = [begun(config, folder / "pair") for _ in range(2)]
    if [ended(child) for child in pair] != [0, 0] or files(folder / "pair") != whole:
        faults.append("two runs at once differ from one")
    return {"kills": killed, "files": len(whole), "kept": kept, "finished": finished, "faults": faults}


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))))
