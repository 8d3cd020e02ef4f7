"""Tasks on a Dask cluster: deaths, errors, interrupts, workers that would compute otherwise."""

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import kills
import pytest
from worker_tasks import (
    die,
    die_once,
    fail_to_prepare,
    keep_twice,
    look_around,
    refuse,
    slow_square,
    tell_for_long,
    time_out,
)

import ecfit
from ecfit import cli
from ecfit._versions import versions
from ecfit.workers import ONE_THREAD, Engine, begin_engine, remote, run_tasks

distributed = pytest.importorskip("distributed", reason="Dask distributed is not installed")
dask = pytest.importorskip("dask")

# The cluster lives in threads of this process, workers are others.
SETTINGS = {
    "distributed.scheduler.allowed-failures": 1,
    # A local cluster gives up a worker that is not back in 15 seconds; a busy machine takes longer.
    "distributed.deploy.lost-worker-timeout": "5 minutes",
}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with (
        dask.config.set(SETTINGS),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=60
        ) as made,
    ):
        yield made


@pytest.fixture
def engine(cluster: Any) -> Iterator[Engine]:
    with begin_engine(scheduler=cluster.scheduler_address) as found:
        yield found


def test_results_are_in_the_order_of_the_tasks_and_all_is_told_once(engine: Engine):
    finished: list[tuple[int, int]] = []
    heard: list[Any] = []
    found = run_tasks(
        slow_square,
        range(5),
        engine=engine,
        finished=lambda i, r: finished.append((i, r)),
        heard=heard.append,
        names=[f"square {i}" for i in range(5)],
    )
    assert found == [0, 1, 4, 9, 16]
    assert sorted(finished) == list(enumerate(found))
    assert sorted(heard) == [("told", x) for x in range(5)]
    assert run_tasks(refuse, [], engine=engine) == []


@pytest.mark.slow
def test_a_worker_has_one_compute_thread(engine: Engine):
    (found,) = run_tasks(look_around, [0], engine=engine)
    assert found["threads"] == ONE_THREAD
    assert found["cpus"] < 1.2


def test_errors_are_raised_here(engine: Engine):
    with pytest.raises(ecfit.EcfitError, match=r"^one is not allowed$"):
        run_tasks(refuse, [0, 1, 2], engine=engine)
    with pytest.raises(ecfit.EcfitError, match=r"^plugin 'x.py' failed to import$"):
        run_tasks(refuse, [0], engine=engine, prepare=fail_to_prepare)
    with pytest.raises(
        ecfit.EcfitError, match=r"^task 1 cannot be sent to a worker: .*in a module or plugin"
    ):
        run_tasks(lambda x: x, [1], engine=engine)


def test_a_result_that_does_not_come_is_asked_for_again(engine: Engine, monkeypatch: pytest.MonkeyPatch):
    """As where its worker died between the task and its fetching; a task's own timeout is an error."""
    real, asked = distributed.Future.result, []

    def late(future: Any, timeout: float | None = None) -> Any:
        asked.append(timeout)
        if len(asked) == 1:
            raise TimeoutError
        return real(future, timeout)

    monkeypatch.setattr(distributed.Future, "result", late)
    finished: list[int] = []
    found = run_tasks(slow_square, range(3), engine=engine, finished=lambda i, _: finished.append(i))
    assert found == [0, 1, 4]
    assert sorted(finished) == [0, 1, 2]
    assert len(asked) == 4
    assert None not in asked
    with pytest.raises(TimeoutError, match=r"^the task's own$"):
        run_tasks(time_out, [0], engine=engine)


def test_an_interrupt_stops_the_tasks_and_leaves_the_cluster(engine: Engine, tmp_path: Path):
    marks = [tmp_path / str(i) for i in range(4)]

    def interrupt() -> None:
        end = time.monotonic() + 20.0
        while time.monotonic() < end and not all(m.exists() for m in marks[:2]):
            time.sleep(0.02)
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        run_tasks(tell_for_long, marks, engine=engine)
    thread.join()
    # Workers are free at once: a task that was cancelled ends when it says something.
    assert run_tasks(slow_square, range(3), engine=engine) == [0, 1, 4]
    assert [m.exists() for m in marks] == [True, True, False, False]
    assert {m.read_text() for m in marks[:2]} <= {"Stopped", "begun"}
    assert "Stopped" in {m.read_text() for m in marks[:2]}


def test_a_killed_worker_loses_nothing_and_nothing_comes_twice(engine: Engine, tmp_path: Path):
    tasks = [(0, None), (1, tmp_path / "mark"), *[(i, None) for i in range(2, 6)]]
    finished: list[int] = []
    found = run_tasks(die_once, tasks, engine=engine, finished=lambda i, _: finished.append(i))
    assert found == sorted(finished) == list(range(6))
    assert (tmp_path / "mark").exists()


def test_what_is_kept_is_written_here_and_told_once(engine: Engine, tmp_path: Path):
    heard: list[Any] = []
    assert run_tasks(keep_twice, [tmp_path], engine=engine, heard=heard.append) == [False]
    assert (tmp_path / "died").exists()
    assert json.loads((tmp_path / "a.json").read_text()) == {"x": 0.1 + 0.2}
    assert json.loads((tmp_path / "b.json").read_text()) == [1, None]
    assert heard == ["kept"]


def test_a_task_that_always_kills_its_worker_is_an_error(engine: Engine, tmp_path: Path):
    message = r"^the fit of b: its worker process died 2 times \(the last was tcp://.*\); where memory"
    with pytest.raises(ecfit.EcfitError, match=message):
        run_tasks(die, [tmp_path / "marks"], engine=engine, names=["the fit of b"])
    assert (tmp_path / "marks").read_text() == "xx"


def test_a_scheduler_that_is_gone_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from ecfit.workers import dask as engines

    monkeypatch.setattr(engines, "ANSWER", 1.0)
    monkeypatch.setattr(engines.Dask, "check", lambda self: None)
    cluster = distributed.LocalCluster(
        n_workers=0, dashboard_address=":0", silence_logs=60, processes=False, protocol="tcp"
    )
    closing = threading.Timer(1.0, cluster.close)
    with begin_engine(scheduler=cluster.scheduler_address) as engine:
        closing.start()
        with pytest.raises(
            ecfit.EcfitError, match=r"^the Dask scheduler at 'tcp://.*' is gone .* goes on from"
        ):
            run_tasks(refuse, [0, 2], engine=engine)
    closing.join()


def test_a_cluster_without_workers_is_told(monkeypatch: pytest.MonkeyPatch):
    from ecfit.workers import dask as engines

    monkeypatch.setattr(engines, "JOIN", 1.0)
    monkeypatch.setattr(engines, "LONELY", 0.5)
    with distributed.LocalCluster(
        n_workers=0, dashboard_address=":0", silence_logs=60, processes=False, protocol="tcp"
    ) as empty:
        address = empty.scheduler_address
        with (
            pytest.raises(ecfit.EcfitError, match=r"has no workers: start some with .*dask worker tcp://"),
            begin_engine(scheduler=address),
        ):
            pass
        # Those that were there have gone: a run waits for others, and not for ever.
        monkeypatch.setattr(engines.Dask, "check", lambda self: None)
        with (
            begin_engine(scheduler=address) as engine,
            pytest.raises(ecfit.EcfitError, match=r"has had no workers for 0.5 seconds; what is finished"),
        ):
            run_tasks(refuse, [0, 2], engine=engine)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere", "ftp://127.0.0.1:1", ""])
def test_no_scheduler_is_told_in_one_line(address: str, monkeypatch: pytest.MonkeyPatch):
    from ecfit.workers import dask as engines

    monkeypatch.setattr(engines, "ANSWER", 0.5)
    with (
        pytest.raises(ecfit.EcfitError, match=r"^no Dask scheduler answers at .*`dask scheduler`") as told,
        begin_engine(scheduler=address),
    ):
        pass
    assert "\n" not in str(told.value)


def test_the_command_ends_with_one_line_and_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    from ecfit.workers import dask as engines

    monkeypatch.setattr(engines, "ANSWER", 0.5)
    arguments = ["run", kills.written(tmp_path), "--results", tmp_path / "results"]
    with pytest.raises(SystemExit) as stopped:
        cli.main([str(a) for a in (*arguments, "--scheduler", "tcp://127.0.0.1:1")])
    assert stopped.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: no Dask scheduler answers at 'tcp://127.0.0.1:1'")
    assert not (tmp_path / "results").exists()  # told before anything is computed


def test_workers_of_two_kinds_are_refused():
    with pytest.raises(ecfit.EcfitError, match="give one of the two"), begin_engine(2, "tcp://127.0.0.1:1"):
        pass


def test_a_missing_dask_is_told(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "ecfit.workers.dask", raising=False)
    with (
        pytest.raises(ecfit.EcfitError, match=r"pip install 'ecfit\[distributed\]'"),
        begin_engine(scheduler="tcp://127.0.0.1:1"),
    ):
        pass


def worker(threads: int = 1) -> Any:
    return SimpleNamespace(address="tcp://there:1", state=SimpleNamespace(nthreads=threads))


def test_a_worker_that_would_compute_otherwise_is_refused(monkeypatch: pytest.MonkeyPatch):
    for name, value in ONE_THREAD.items():
        monkeypatch.setenv(name, value)
    remote.check(remote.build(), worker())
    with pytest.raises(ecfit.EcfitError, match=r"jax is .* there and 0\.1 here; give both the same$"):
        remote.check({**remote.build(), "jax": "0.1"}, worker())
    with pytest.raises(ecfit.EcfitError, match=r"has 4 threads.*--nthreads 1 --nworkers 4$"):
        remote.check(remote.build(), worker(4))
    monkeypatch.delenv("PJRT_NPROC")  # and JAX has loaded
    with pytest.raises(ecfit.EcfitError, match=r"start it with PJRT_NPROC=1 in its environment$"):
        remote.check(remote.build(), worker())


def test_workers_are_compared_in_all_that_provenance_names():
    assert {name.lower() for name in remote.build()} >= set(versions())


def test_threads_are_set_where_nothing_has_read_them(monkeypatch: pytest.MonkeyPatch):
    for name, value in ONE_THREAD.items():
        monkeypatch.setenv(name, value)
    monkeypatch.delenv("PJRT_NPROC")
    monkeypatch.delitem(sys.modules, "jax")
    remote.check(remote.build(), worker())
    assert os.environ["PJRT_NPROC"] == "1"
