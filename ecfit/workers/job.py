"""Tasks to be done, and what an engine is that does them."""

import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ecfit.errors import EcfitError


@dataclass(frozen=True)
class Job:
    """A function to be called with each of some tasks.

    Attributes:
        function: found by import in a fresh process.
        tasks: its arguments, which can be pickled.
        order: the indices of the tasks, in the order in which they begin.
        names: what messages call the tasks.
        prepare: called by a worker before it does a task, to load a user's modules.
    """

    function: Callable[[Any], Any]
    tasks: Sequence[Any]
    order: Sequence[int]
    names: Sequence[str] | None = None
    prepare: Callable[[], object] | None = None

    def name(self, index: int) -> str:
        """What messages call a task."""
        return self.names[index] if self.names else f"task {index + 1}"

    def pickled(self, index: int) -> bytes:
        """A task for `work` in another process. Raises `EcfitError` where it cannot be pickled."""
        try:
            return pickle.dumps((self.function, self.tasks[index]))
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise EcfitError(
                f"{self.name(index)} cannot be sent to a worker: {error}; {_WHERE_TO_DEFINE}"
            ) from None

    def deadly(self, index: int, deaths: int, why: str) -> EcfitError:
        """The error for a task whose worker died again and again."""
        return EcfitError(
            f"{self.name(index)}: its worker process died {deaths} times ({why}); where memory ran out, free "
            "some or make the task smaller"
        )


class Engine(Protocol):
    """Does jobs. `Local` does them in processes of this machine, `Dask` on a cluster."""

    def run(self, job: Job, done: Callable[[int, Any], object], heard: Callable[[Any], object]) -> None:
        """Do all tasks of a job.

        Args:
            job: the tasks.
            done: called with index and result of every task, once, in order of time.
            heard: called with what tasks `tell`, in order of time.

        What a task raises is raised here, and no other task begins. A task whose worker died is done again;
        raises `EcfitError` where that goes on.
        """
        ...


_WHERE_TO_DEFINE = (
    "define functions and classes of tasks in a module or plugin, not in the script that is run"
)


def work(pickled: bytes) -> Any:
    """Do a task of `Job.pickled`. Raises `EcfitError` where this process cannot find its function."""
    try:
        function, task = pickle.loads(pickled)
    except (AttributeError, ImportError) as error:
        raise EcfitError(f"a worker process cannot load its task: {error}; {_WHERE_TO_DEFINE}") from None
    return function(task)
