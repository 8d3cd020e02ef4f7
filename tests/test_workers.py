"""Worker processes: order, errors, death, interrupts, and one compute thread."""

import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from worker_tasks import (
    die,
    die_once,
    fail_to_prepare,
    leave_a_mark,
    look_around,
    process_of,
    refuse,
    remember,
    remembered,
    slow_square,
    wait_long,
)

import ecfit
from ecfit.workers import AGAIN, ONE_THREAD, Local, check_workers, run_tasks, usable_cpus


def one_thread(environment: pytest.MonkeyPatch) -> None:
    """As if this process had been started with one compute thread."""
    for name, value in ONE_THREAD.items():
        environment.setenv(name, value)


def many_threads(environment: pytest.MonkeyPatch) -> None:
    """As if it had not, whatever the tests are run with."""
    for name in ONE_THREAD:
        environment.delenv(name, raising=False)


def alive(pid: int) -> bool:
    """Whether a process runs; one that ended but that nobody has waited for does not."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except ProcessLookupError:
        return False
    except FileNotFoundError:  # gone since, or no /proc
        return not Path("/proc").exists()


def gone(pids: list[int], seconds: float = 10.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not any(map(alive, pids)):
            return True
        time.sleep(0.05)
    return False


def test_results_are_in_the_order_of_the_tasks_and_told_in_that_of_time():
    finished: list[tuple[int, int]] = []
    heard: list[Any] = []
    found = run_tasks(
        slow_square,
        range(5),
        engine=Local(2),
        finished=lambda i, r: finished.append((i, r)),
        heard=heard.append,
    )
    assert found == [0, 1, 4, 9, 16]
    assert sorted(finished) == list(enumerate(found))
    assert sorted(heard) == [("told", x) for x in range(5)]


def test_a_process_of_one_thread_needs_no_other_for_one_worker(monkeypatch: pytest.MonkeyPatch):
    many_threads(monkeypatch)
    (other,) = run_tasks(process_of, [0], engine=Local(1))
    assert other != os.getpid()
    one_thread(monkeypatch)
    assert run_tasks(process_of, [0, 1], engine=Local(1)) == [os.getpid()] * 2
    assert os.getpid() not in run_tasks(process_of, [0, 1], engine=Local(2))


@pytest.mark.parametrize("here", [False, True])
def test_the_most_expensive_task_begins_first(here: bool, monkeypatch: pytest.MonkeyPatch):
    (one_thread if here else many_threads)(monkeypatch)
    heard: list[Any] = []
    assert run_tasks(slow_square, [1, 2, 3], engine=Local(1), costs=[5.0, 9.0, 7.0], heard=heard.append) == [
        1,
        4,
        9,
    ]
    assert [x for _, x in heard] == [2, 3, 1]


def test_no_tasks_are_no_work():
    assert run_tasks(refuse, [], engine=Local(4)) == []


def test_an_error_of_a_task_is_raised_here():
    with pytest.raises(ecfit.EcfitError, match=r"^one is not allowed$"):
        run_tasks(refuse, [0, 1, 2], engine=Local(2))


def test_after_an_error_no_task_begins(tmp_path: Path):
    with pytest.raises(ValueError, match="zero"):
        run_tasks(leave_a_mark, [(i, tmp_path) for i in range(6)], engine=Local(2))
    assert list(tmp_path.iterdir()) == []


def test_what_a_worker_cannot_find_is_told():
    with pytest.raises(ecfit.EcfitError, match=r"^task 1 cannot be sent to a worker: .*local.*in a module"):
        run_tasks(lambda x: x, [1, 2], engine=Local(2))


def test_a_killed_worker_is_replaced_and_its_task_run_again(tmp_path: Path):
    tasks = [(0, None), (1, tmp_path / "mark"), *[(i, None) for i in range(2, 6)]]
    heard: list[int] = []
    assert run_tasks(die_once, tasks, engine=Local(2), heard=heard.append) == list(range(6))
    assert heard == [1]  # what it said before it died is not lost


def test_a_task_that_always_kills_its_worker_is_an_error_and_others_are_done(tmp_path: Path):
    finished: list[int] = []
    message = r"^the fit of b: its worker process died 3 times \(killed by SIGKILL\); where memory"
    with pytest.raises(ecfit.EcfitError, match=message):
        run_tasks(
            die,
            [None, tmp_path / "marks", None],
            engine=Local(2),
            names=["the fit of a", "the fit of b", "the fit of c"],
            finished=lambda index, _: finished.append(index),
        )
    assert (tmp_path / "marks").read_text() == "x" * (1 + AGAIN)
    assert 2 in finished


def test_a_worker_has_one_compute_thread_and_this_process_keeps_its_own(monkeypatch: pytest.MonkeyPatch):
    many_threads(monkeypatch)
    before = dict(os.environ)
    (found,) = run_tasks(look_around, [0], engine=Local(1))
    assert dict(os.environ) == before
    assert not found["loaded"]  # the threads are set before anything reads them
    assert found["threads"] == ONE_THREAD
    assert found["cpus"] < 1.2


def test_every_worker_is_prepared():
    found = run_tasks(remembered, range(4), engine=Local(2), prepare=partial(remember, "here"))
    assert found == ["here"] * 4
    with pytest.raises(ecfit.EcfitError, match=r"plugin 'x.py' failed to import"):
        run_tasks(remembered, range(4), engine=Local(2), prepare=fail_to_prepare)


def test_an_interrupt_ends_the_workers_and_begins_no_task(tmp_path: Path):
    marks = [tmp_path / str(i) for i in range(4)]

    def interrupt() -> None:
        end = time.monotonic() + 20.0
        while time.monotonic() < end and not all(m.exists() and m.read_text() for m in marks[:2]):
            time.sleep(0.02)
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run_tasks(wait_long, marks, engine=Local(2))
    thread.join()
    assert time.monotonic() - started < 30.0
    assert gone([int(m.read_text()) for m in marks[:2]])
    assert not marks[2].exists()


SCRIPT = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from worker_tasks import {function}
from ecfit.workers import Local, run_tasks
print(run_tasks({function}, {tasks}, engine=Local(2)))
"""


def script(tmp_path: Path, function: str, tasks: str) -> Path:
    path = tmp_path / "script.py"
    path.write_text(SCRIPT.format(tests=str(Path(__file__).parent), function=function, tasks=tasks))
    return path


def test_a_script_without_a_guard_is_not_run_again_in_the_workers(tmp_path: Path):
    path = script(tmp_path, "refuse", "[0, 2, 3]")
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, check=True)
    assert done.stdout == "[0, 2, 3]\n"


def test_a_function_of_the_script_is_refused_with_the_remedy(tmp_path: Path):
    path = script(tmp_path, "refuse", "[0]")
    path.write_text(path.read_text() + "def f(x): return x\nrun_tasks(f, [1, 2], engine=Local(2))\n")
    done = subprocess.run([sys.executable, path], capture_output=True, text=True)
    assert "EcfitError: a worker process cannot load its task" in done.stderr
    assert "in a module or plugin" in done.stderr


def test_workers_end_with_their_parent(tmp_path: Path):
    marks = [tmp_path / "a", tmp_path / "b"]
    path = script(tmp_path, "wait_long", f"[Path(p) for p in {[str(m) for m in marks]}]")
    parent = subprocess.Popen([sys.executable, path], stderr=subprocess.DEVNULL)
    end = time.monotonic() + 20.0
    while time.monotonic() < end and not all(m.exists() and m.read_text() for m in marks):
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    assert gone([int(m.read_text()) for m in marks])


def test_the_number_of_workers_is_checked():
    assert check_workers(None) == usable_cpus() >= 1
    assert check_workers(3) == 3
    for bad in (0, -1, 1.5, True, "2"):
        with pytest.raises(ecfit.EcfitError, match="workers must be a whole number, 1 or more"):
            check_workers(bad)  # type: ignore[arg-type]
