"""Tasks of `test_workers.py`: spawned workers import this module, so it loads little."""

import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

from ecfit.errors import EcfitError
from ecfit.workers import ONE_THREAD, keep, shared, tell


def slow_square(x: int) -> int:
    """Later tasks end earlier."""
    time.sleep(0.3 / (1 + x))
    tell(("told", x))
    return x * x


def process_of(_: int) -> int:
    time.sleep(0.3)
    return os.getpid()


def refuse(x: int) -> int:
    if x == 1:
        raise EcfitError("one is not allowed")
    return x


def leave_a_mark(task: tuple[int, Path]) -> None:
    """Number 0 fails; the others write a file."""
    index, folder = task
    if index == 0:
        raise ValueError("zero")
    time.sleep(1.0)
    (folder / str(index)).write_text("")


def die_once(task: tuple[int, Path | None]) -> int:
    """Where there is a place for the marker, the first call kills its process."""
    index, marker = task
    if marker is not None and not marker.exists():
        marker.write_text("")
        tell(index)
        os.kill(os.getpid(), signal.SIGKILL)
    return index


def die(marks: Path | None) -> int:
    if marks is None:
        time.sleep(0.2)
        return 1
    with marks.open("a") as file:
        file.write("x")
    os.kill(os.getpid(), signal.SIGKILL)
    return 0


def look_around(_: int) -> dict[str, Any]:
    """What a worker is: its modules and environment, and what its compute costs."""
    before = "numpy" in sys.modules or "jax" in sys.modules
    from ecfit._jax import jax, jnp

    x = jnp.ones((600, 600))
    work = jax.jit(lambda x: x @ x + jnp.sum(jnp.sin(x)))
    work(x).block_until_ready()
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(20):
        work(x).block_until_ready()
    elapsed = time.perf_counter() - wall
    return {
        "loaded": before,
        "threads": {name: os.environ.get(name) for name in ONE_THREAD},
        "cpus": (time.process_time() - cpu) / elapsed,
    }


def remember(name: str) -> None:
    os.environ["ECFIT_TEST_PREPARED"] = name


def remembered(_: int) -> str | None:
    return os.environ.get("ECFIT_TEST_PREPARED")


def fail_to_prepare() -> None:
    raise EcfitError("plugin 'x.py' failed to import")


def wait_long(marker: Path) -> None:
    marker.write_text(str(os.getpid()))
    time.sleep(60.0)


def keep_twice(path: Path) -> bool:
    """Keeps two files; the first call then kills its process where there is a place for the marker."""
    keep(path / "a.json", {"x": 0.1 + 0.2})
    keep(path / "b.json", [1, float("nan")])
    tell("kept")
    marker = path / "died"
    if not marker.exists():
        marker.write_text("")
        time.sleep(0.5)  # what it said leaves this process every few milliseconds
        os.kill(os.getpid(), signal.SIGKILL)
    return shared()


def tell_for_long(marker: Path) -> None:
    """As a long fit: it ends early only where it is refused to go on."""
    marker.write_text("begun")
    try:
        for step in range(600):
            tell(step)
            time.sleep(0.1)
    except Exception as error:
        marker.write_text(type(error).__name__)
        raise


def time_out(task: object) -> None:
    raise TimeoutError("the task's own")
