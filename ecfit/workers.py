"""Worker processes with one compute thread each, for tasks of seconds and more. No JAX here.

Spawned, never forked: a fork of a process in which JAX has run hangs. A worker that dies is replaced, and
what a task returns depends neither on the number of workers nor on that of processors.
"""

import os
import pickle
from collections import Counter, deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from ecfit._spawn import ONE_THREAD as ONE_THREAD
from ecfit._spawn import Context, begin, call, listener
from ecfit._spawn import tell as tell
from ecfit.errors import EcfitError

Task = TypeVar("Task")
Result = TypeVar("Result")

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


def run_tasks(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    *,
    workers: int | None = None,
    costs: Sequence[float] | None = None,
    names: Sequence[str] | None = None,
    finished: Callable[[int, Result], object] | None = None,
    heard: Callable[[Any], object] | None = None,
    prepare: Callable[[], object] | None = None,
) -> list[Result]:
    """`[function(task) for task in tasks]`, side by side in worker processes.

    Every task has one compute thread, whatever the number of workers: with two, XLA and BLAS add in another
    order, and a descent that stops elsewhere turns the last bit into the ninth digit. One worker runs in this
    process where that has one thread too (`ONE_THREAD` in its environment before NumPy and JAX loaded); any
    other is spawned, which costs seconds of imports.

    Args:
        function: found by import in a fresh process, so neither local nor of the script that is run.
        tasks: arguments that can be pickled.
        workers: processes at most; by default the usable processors.
        costs: a guess at the time of each task; those that take longest begin first.
        names: what messages call the tasks.
        finished: called with index and result of each task when it is done, in order of time.
        heard: called with what tasks `tell`, in order of time.
        prepare: called once in every spawned worker before its first task, to load a user's modules; this
            process is taken to have them.

    Returns results in the order of the tasks. What a task raises is raised here, and no other task begins.
    A task whose worker died is run again, alone and at most twice, so it has to bear being half done.
    Raises `EcfitError` where its worker dies again, and for a bad number of workers.
    """
    workers = min(check_workers(workers), len(tasks))
    order: Sequence[int] = range(len(tasks))
    if costs is not None:
        order = sorted(order, key=lambda i: -costs[i])
    results: dict[int, Result] = {}

    def done(index: int, result: Result) -> None:
        results[index] = result
        if finished is not None:
            finished(index, result)

    if workers <= 1 and all(os.environ.get(name) == value for name, value in ONE_THREAD.items()):
        before = listener.set(heard)
        try:
            for index in order:
                done(index, function(tasks[index]))
        finally:
            listener.reset(before)
        return [results[index] for index in range(len(tasks))]

    untried, suspects, deaths = deque(order), deque[int](), Counter[int]()
    while untried or suspects:
        # Alone, a task has all the memory, and none beside it is blamed for its end.
        queue, most = (untried, workers) if untried else (suspects, 1)
        lost, why = _one_pool(lambda i: pickle.dumps((function, tasks[i])), queue, most, done, heard, prepare)
        for index in lost:
            deaths[index] += 1
            if deaths[index] > AGAIN:
                raise EcfitError(
                    f"{names[index] if names else f'task {index + 1}'}: its worker process died "
                    f"{deaths[index]} times ({why}); where memory ran out, free some or make the task smaller"
                )
            suspects.append(index)
    return [results[index] for index in range(len(tasks))]


def _one_pool(
    pickled: Callable[[int], bytes],
    queue: deque[int],
    workers: int,
    done: Callable[[int, Any], object],
    heard: Callable[[Any], object] | None,
    prepare: Callable[[], object] | None,
) -> tuple[list[int], str]:
    """Run tasks from `queue` until it is empty or a worker dies; the tasks that were lost, and why."""
    context = Context()
    messages = context.SimpleQueue()
    pool = ProcessPoolExecutor(workers, context, begin, (messages, pickle.dumps(prepare)))
    running: dict[Future[Any], int] = {}
    lost: list[int] = []
    broken, finished = False, False

    def listen() -> None:
        while not messages.empty():
            message = messages.get()
            if heard is not None:
                heard(message)

    try:
        while running or (queue and not broken):
            # No more than can run: what waits in the pool would be lost, or begun after an interrupt.
            while queue and not broken and len(running) < workers:
                try:
                    running[pool.submit(call, pickled(queue[0]))] = queue[0]
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
