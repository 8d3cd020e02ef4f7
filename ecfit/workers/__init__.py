"""Tasks of seconds and more, side by side: in processes of this machine, or on a cluster. No JAX here.

What a task returns depends neither on the engine nor on the number of workers: every task has one compute
thread, and a worker that dies is replaced.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from ecfit.errors import EcfitError
from ecfit.workers.home import keep as keep
from ecfit.workers.home import shared as shared
from ecfit.workers.home import tell as tell
from ecfit.workers.job import Engine as Engine
from ecfit.workers.local import AGAIN as AGAIN
from ecfit.workers.local import Local as Local
from ecfit.workers.local import check_workers as check_workers
from ecfit.workers.local import usable_cpus as usable_cpus
from ecfit.workers.tasks import run_tasks as run_tasks
from ecfit.workers.threads import ONE_THREAD as ONE_THREAD


@contextmanager
def begin_engine(workers: int | None = None, scheduler: str | None = None) -> Iterator[Engine]:
    """The engine of `workers` processes of this machine, or of the Dask scheduler at an address.

    Raises `EcfitError` where both are given, for a bad number, and where no cluster answers.
    """
    if scheduler is None:
        yield Local(check_workers(workers))
        return
    if workers is not None:
        raise EcfitError(
            "workers are processes of this machine, those of a scheduler are its own: give one of the two"
        )
    from ecfit.workers.dask import connected  # Dask takes half a second to load, and is optional

    with connected(scheduler) as engine:
        yield engine
