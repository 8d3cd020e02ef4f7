"""Tasks in processes of this machine.

Spawned, never forked: a fork of a process in which JAX has run hangs. A worker that dies is replaced.
"""

import os
import pickle
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

from ecfit.errors import EcfitError
from ecfit.workers.home import Home, home
from ecfit.workers.job import Job
from ecfit.workers.spawn import Context, begin, call
from ecfit.workers.threads import ONE_THREAD

# A task whose worker died is begun again so often.
AGAIN = 2
# Seconds between two looks at what workers tell.
_PATIENCE = 0.2


def usable_cpus() -> int:
    """Processors that this process may use: fewer than the machine has where its affinity is limited."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def check_workers(workers: int | None) -> int:
    """The number of workers: all usable processors for None. Raises `EcfitError` unless it is 1 or more."""
    if workers is None:
        return usable_cpus()
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise EcfitError(f"workers must be a whole number, 1 or more, got {workers!r}")
    return workers


@dataclass(frozen=True)
class Local:
    """An `Engine` of at most `workers` processes; by default as many as there are usable processors.

    One worker runs in this process where that has one thread too (`ONE_THREAD` in its environment before
    NumPy and JAX loaded); any other is spawned, which costs seconds of imports.
    """

    workers: int | None = None

    def run(self, job: Job, done: Callable[[int, Any], object], heard: Callable[[Any], object]) -> None:
        """See `Engine`. A worker that dies breaks the pool, and with it all tasks that are running.

        Each of them is begun again at the end, alone, one after the other, and at most twice: which of them
        killed the worker nobody says.
        """
        workers = min(check_workers(self.workers), len(job.tasks))
        if workers <= 1 and all(os.environ.get(name) == value for name, value in ONE_THREAD.items()):
            _here(job, done, heard)
            return
        untried, suspects, deaths = deque(job.order), deque[int](), Counter[int]()
        while untried or suspects:
            # Alone, a task has all the memory, and none beside it is blamed for its end.
            queue, most = (untried, workers) if untried else (suspects, 1)
            lost, why = _one_pool(job, queue, most, done, heard)
            for index in lost:
                deaths[index] += 1
                if deaths[index] > AGAIN:
                    raise job.deadly(index, deaths[index], why)
                suspects.append(index)


def _here(job: Job, done: Callable[[int, Any], object], heard: Callable[[Any], object]) -> None:
    before = home.set(Home(heard))
    try:
        for index in job.order:
            done(index, job.function(job.tasks[index]))
    finally:
        home.reset(before)


def _one_pool(
    job: Job,
    queue: deque[int],
    workers: int,
    done: Callable[[int, Any], object],
    heard: Callable[[Any], object],
) -> tuple[list[int], str]:
    """Run tasks from `queue` until it is empty or a worker dies; the tasks that were lost, and why."""
    context = Context()
    messages = context.SimpleQueue()
    pool = ProcessPoolExecutor(workers, context, begin, (messages, pickle.dumps(job.prepare)))
    running: dict[Future[Any], int] = {}
    lost: list[int] = []
    broken, finished = False, False

    def listen() -> None:
        while not messages.empty():
            heard(messages.get())

    try:
        while running or (queue and not broken):
            # No more than can run: what waits in the pool would be lost, or begun after an interrupt.
            while queue and not broken and len(running) < workers:
                try:
                    running[pool.submit(call, job.pickled(queue[0]))] = queue[0]
                    queue.popleft()
                except BrokenProcessPool:
                    broken = True
            ready, _ = wait(running, _PATIENCE, FIRST_COMPLETED)
            listen()
            for future in sorted(ready, key=running.__getitem__):
                index = running.pop(future)
                try:
                    result = future.result()
                except BrokenProcessPool:
                    broken = True
                    lost.append(index)
                else:
                    done(index, result)
        finished = True
    finally:
        if not finished:
            context.kill()
        pool.shutdown(wait=True, cancel_futures=True)
        if finished:
            listen()
        messages.close()
    return lost, context.end()
