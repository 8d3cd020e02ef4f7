"""What a Dask cluster costs beside the fits: its start, and the time of a task with and without a table.

    pip install -e '.[distributed]'
    python benchmarks/cluster.py

Two workers of one thread each on this machine, so that no network is in the times.
"""

import tempfile
import time
from operator import attrgetter
from pathlib import Path
from typing import Any

import dask
import distributed

from ecfit.files import Carried
from ecfit.workers import Engine, begin_engine, run_tasks

# A table of 1024 x 1024: values and errors of 8 bytes, a status of 1.
TABLE = 17 * 2**20


def milliseconds(engine: Engine, size: int, count: int, folder: Path) -> float:
    """The time of a task that carries a file of `size` bytes and does nothing."""
    path = folder / str(size)
    path.write_bytes(bytes(size))
    started = time.perf_counter()
    run_tasks(attrgetter("path"), [Carried(path)] * count, engine=engine)
    return 1e3 * (time.perf_counter() - started) / count


def two_workers() -> Any:
    """A cluster."""
    return distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")


def main() -> None:
    """Print the times."""
    started = time.perf_counter()
    with (
        tempfile.TemporaryDirectory() as folder,
        dask.config.set({"distributed.deploy.lost-worker-timeout": "5 minutes"}),
        two_workers() as cluster,
        begin_engine(scheduler=cluster.scheduler_address) as engine,
    ):
        print(f"a cluster of two workers starts in {time.perf_counter() - started:.1f} s")
        milliseconds(engine, 1, 4, Path(folder))  # workers load ecfit
        print(f"a task takes {milliseconds(engine, 1, 400, Path(folder)):.1f} ms")
        print(f"one with a table of 1024 x 1024 {milliseconds(engine, TABLE, 40, Path(folder)):.0f} ms")


if __name__ == "__main__":
    main()
