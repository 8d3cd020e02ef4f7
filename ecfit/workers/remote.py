"""What a Dask worker runs of ecfit. No JAX here, and of Dask only the worker that we are in."""

import hashlib
import os
import pickle
import platform
import sys
from functools import cache
from pathlib import Path
from typing import Any

from ecfit._versions import PACKAGES, versions
from ecfit.errors import EcfitError
from ecfit.workers.home import Home, home
from ecfit.workers.job import work
from ecfit.workers.threads import ONE_THREAD

# Events of all runs have one topic: a scheduler keeps the last 1000 of each topic in memory, for ever.
TOPIC = "ecfit"


class Stopped(Exception):
    """The run that asked for this task has been stopped."""


@cache
def build() -> dict[str, str]:
    """What computes numbers in this process; two that differ in it may differ in the last bits of a fit."""
    found = versions()
    return {
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "ecfit": f"{found.get('ecfit', 'missing')} (source {_source()})",
        **{name: found.get(name, "missing") for name in PACKAGES},
        "XLA_FLAGS": os.environ.get("XLA_FLAGS", "").strip() or "unset",
    }


def _source() -> str:
    """A hash of ecfit's own code: versions do not tell edited copies apart."""
    root = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:8]


def check(wanted: dict[str, str], dask_worker: Any = None) -> None:
    """Raise `EcfitError` where this worker would not compute what `build` said elsewhere, or not so fast.

    Args:
        wanted: `build()` of the process that has the results.
        dask_worker: this worker; Dask gives it to what `Client.run` runs.
    """
    worker = dask_worker or _worker()
    differing = [
        f"{k} is {build().get(k)} there and {v} here" for k, v in wanted.items() if build().get(k) != v
    ]
    if differing:
        raise EcfitError(
            f"worker {worker.address} might not compute the same numbers: {', '.join(differing)}; "
            "give both the same"
        )
    if worker.state.nthreads != 1:
        raise EcfitError(
            f"worker {worker.address} has {worker.state.nthreads} threads, and a fit has one process for "
            f"itself: start it with --nthreads 1 --nworkers {worker.state.nthreads}"
        )
    # Libraries read these when they load: JAX has not, before the first of our tasks; NumPy has, with Dask,
    # whose nanny sets the three names of usual builds.
    late = [name for name, value in ONE_THREAD.items() if os.environ.get(name) != value]
    if "jax" not in sys.modules:
        late = [
            name for name in late if name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        ]
    if late:
        raise EcfitError(
            f"worker {worker.address} was started with more than one compute thread: start it with "
            f"{' '.join(f'{name}=1' for name in late)} in its environment"
        )
    os.environ.update(ONE_THREAD)


def _worker() -> Any:
    from distributed import get_worker

    return get_worker()


def call(
    run: str, index: int, wanted: dict[str, str], prepare: bytes, pickled: bytes
) -> tuple[Any, list[bytes]]:
    """Do a task of `Job.pickled`: its result, and all that it told and kept, in order.

    What it tells and keeps goes home at once, too, as an event: a run that is killed has it by then. Events
    may get lost with a connection; the list does not.

    Args:
        run: of the process that asks, to tell its events from others'.
        index: of the task.
        wanted: as `check`.
        prepare: pickled; see `run_tasks`.
        pickled: the task.
    """
    worker = _worker()
    check(wanted, worker)
    key = worker.get_current_task()
    said: list[bytes] = []

    def send(*message: Any) -> None:
        task = worker.state.tasks.get(key)
        if task is None or task.state == "cancelled":
            raise Stopped
        said.append(pickle.dumps(message))
        event = {"run": run, "task": index, "number": len(said) - 1, "message": said[-1]}
        worker.log_event(TOPIC, event)

    before = home.set(
        Home(
            tell=lambda message: send("tell", message),
            keep=lambda path, data: send("keep", path, data),
            shared=False,
        )
    )
    try:
        function = pickle.loads(prepare)
        if function is not None:
            function()
        return work(pickled), said
    finally:
        home.reset(before)
