"""Where the results of a task go. A task tells and keeps; where it runs, it need not know."""

from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ecfit.files import write_json


@dataclass(frozen=True)
class Home:
    """The way home from where a task runs.

    Attributes:
        tell: passes a message to `heard` of `run_tasks`.
        keep: writes a JSON file, here or where the task comes from.
        shared: whether a task that is begun again finds here what was kept before.
    """

    tell: Callable[[Any], object]
    keep: Callable[[Path, Any], object] = write_json
    shared: bool = True


_HERE = Home(lambda message: None)

home: ContextVar[Home] = ContextVar("home", default=_HERE)


def tell(message: Any) -> None:
    """Within a task: pass a short message (some 100 bytes, pickled) to `heard` of `run_tasks`, at once."""
    home.get().tell(message)


def keep(path: Path, data: Any) -> None:
    """Within a task: keep a result at once, as a JSON file of the process that asked for the task.

    It outlives the task and its worker. Where it cannot be written the run ends with an `EcfitError`: raised
    in the task on this machine, and not on a cluster, where tasks do not write.
    """
    home.get().keep(path, data)


def shared() -> bool:
    """Within a task: whether what an earlier attempt kept is on a disk that this one reads, too."""
    return home.get().shared
