"""A function called with many arguments, side by side."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from ecfit.workers.job import Engine, Job
from ecfit.workers.local import Local

Task = TypeVar("Task")
Result = TypeVar("Result")


def run_tasks(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    *,
    engine: Engine | None = None,
    costs: Sequence[float] | None = None,
    names: Sequence[str] | None = None,
    finished: Callable[[int, Result], object] | None = None,
    heard: Callable[[Any], object] | None = None,
    prepare: Callable[[], object] | None = None,
) -> list[Result]:
    """`[function(task) for task in tasks]`, side by side.

    Every task has one compute thread, wherever it runs: with two, XLA and BLAS add in another order, and a
    descent that stops elsewhere turns the last bit into the ninth digit.

    Args:
        function: found by import in a fresh process, so neither local nor of the script that is run.
        tasks: arguments that can be pickled.
        engine: what does them; by default `Local()`, processes of this machine.
        costs: a guess at the time of each task; those that take longest begin first.
        names: what messages call the tasks.
        finished: called with index and result of each task when it is done, in order of time.
        heard: called with what tasks `tell`, in order of time.
        prepare: called in every worker before a task, to load a user's modules: once or often, so that it
            has to know what it did. This process is taken to have them.

    Returns results in the order of the tasks. What a task raises is raised here, and no other task begins.
    A task whose worker died is run again, so it has to bear being half done. Raises `EcfitError` where its
    worker dies again and again, and for tasks that cannot be sent.
    """
    order: Sequence[int] = range(len(tasks))
    if costs is not None:
        order = sorted(order, key=lambda i: -costs[i])
    results: dict[int, Result] = {}

    def done(index: int, result: Result) -> None:
        results[index] = result
        if finished is not None:
            finished(index, result)

    def listen(message: Any) -> None:
        if heard is not None:
            heard(message)

    (engine or Local()).run(Job(function, tasks, order, names, prepare), done, listen)
    return [results[index] for index in range(len(tasks))]
