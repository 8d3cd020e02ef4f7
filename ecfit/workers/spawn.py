"""A worker process: spawned without the parent's script, with one compute thread, ended with its parent.

No JAX here: the threads have to be set before it loads.
"""

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from contextlib import suppress
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.queues import SimpleQueue
from types import ModuleType
from typing import Any

from ecfit.workers.home import Home, home
from ecfit.workers.job import work
from ecfit.workers.threads import ONE_THREAD


class Process(SpawnProcess):
    """A process that does not run the parent's script again.

    Python would, to find what the script defines: a script without `if __name__ == "__main__"` would then
    start its study in every worker, and one that imports NumPy would do so before the threads are set.
    """

    def start(self) -> None:
        script = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            super().start()
        finally:
            sys.modules["__main__"] = script


class Context(SpawnContext):
    """Starts the pool's processes and knows them: the pool itself cannot end them early."""

    def __init__(self) -> None:
        self.processes: list[Process] = []

    def Process(self, *args: Any, **settings: Any) -> Process:  # type: ignore[override]
        process = Process(*args, **settings)
        self.processes.append(process)
        return process

    def kill(self) -> None:
        for process in self.processes:
            if process.pid is not None:
                with suppress(OSError):
                    process.kill()

    def end(self) -> str:
        """How the first process ended."""
        code = self.processes[0].exitcode if self.processes else None
        if code is not None and code < 0:
            with suppress(ValueError):
                return f"killed by {signal.Signals(-code).name}"
        return f"exit code {code}"


# In a worker: what `prepare` raised; every task raises it.
_fault: Exception | None = None


def begin(messages: "SimpleQueue[Any]", prepare: bytes) -> None:
    """The first thing that a worker does; NumPy and JAX load later, with `prepare` or with the first task."""
    global _fault
    os.environ.update(ONE_THREAD)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt ends
    threading.Thread(target=_follow_parent, daemon=True).start()
    home.set(Home(messages.put))
    try:
        function = pickle.loads(prepare)
        if function is not None:
            function()
    except Exception as error:
        _fault = error


def _follow_parent() -> None:
    """End with the parent, even if it is killed: nobody would take the results."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def call(pickled: bytes) -> Any:
    """Do a task: unpickled here and not by the pool, to which an error there is a dead worker."""
    if _fault is not None:
        raise _fault
    return work(pickled)
