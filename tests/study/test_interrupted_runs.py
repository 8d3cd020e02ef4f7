"""What the world does to a run: kills, interrupts, full disks, folders that refuse, a second run."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import kills
import pytest

from ecfit import cli
from ecfit.files import STALE, clear_parts
from ecfit.workers import ONE_THREAD

ENVIRONMENT = {**os.environ, **ONE_THREAD}


def killed(folder: Path, count: int) -> dict[str, object]:
    done = subprocess.run(
        [sys.executable, str(Path(kills.__file__)), str(folder), str(count), "1"],
        capture_output=True, text=True, env=ENVIRONMENT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("count", [3, pytest.param(200, marks=pytest.mark.slow)])
def test_kills_lose_nothing_that_was_finished_and_two_runs_at_once_agree(tmp_path: Path, count: int):
    found = killed(tmp_path, count)
    assert found["faults"] == []
    assert found["kills"] == count
    if count > 100:
        assert found["kept"] > count  # they fell while files were written, too


def called(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[object, str]:
    with pytest.raises(SystemExit) as stopped:
        cli.main([str(a) for a in arguments])
    return stopped.value.code, capsys.readouterr().err


def told_in_one_line(code: object, err: str, words: str) -> None:
    assert code == 2
    (line,) = [line for line in err.splitlines() if "error" in line]
    assert line.startswith("error: cannot ")
    assert words in line


def test_a_disk_that_is_full_is_told_and_leaves_no_part(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    resource = pytest.importorskip("resource")
    config = kills.written(tmp_path)
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, old[1]))
    try:
        code, err = called(capsys, "run", config, "--results", tmp_path / "results")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
    told_in_one_line(code, err, os.strerror(errno.EFBIG))
    assert list((tmp_path / "results").rglob("*.part")) == []


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EDQUOT])
def test_every_fault_of_a_disk_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], fault: int
):
    config = kills.written(tmp_path)

    def refuse(*_: object) -> None:
        raise OSError(fault, os.strerror(fault))

    monkeypatch.setattr("os.fsync", refuse)
    code, err = called(capsys, "run", config, "--results", tmp_path / "results")
    told_in_one_line(code, err, os.strerror(fault))
    assert [p.name for p in (tmp_path / "results").rglob("*") if p.is_file()] == []


def test_a_folder_that_may_not_be_written_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    results = tmp_path / "results"
    results.mkdir()
    results.chmod(0o500)
    if os.access(results, os.W_OK):  # root writes anywhere but to the kernel's own files
        results = Path("/sys/kernel/ecfit")
        if not results.parent.is_dir():
            pytest.skip("root may write to every folder here")
    code, err = called(capsys, "run", kills.written(tmp_path), "--results", results)
    told_in_one_line(code, err, str(results))


def test_what_killed_runs_left_half_written_is_removed_later(tmp_path: Path):
    old, new, other = tmp_path / ".a.json.x1.part", tmp_path / ".b.json.x2.part", tmp_path / "c.part"
    for path in (old, new, other):
        path.write_text("half")
    os.utime(old, (time.time() - 2 * STALE,) * 2)
    clear_parts(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == [new.name, other.name]
    clear_parts(tmp_path / "nowhere")


@pytest.mark.slow
def test_an_interrupt_says_how_to_go_on_and_loses_nothing(tmp_path: Path):
    config, results = kills.written(tmp_path), tmp_path / "results"
    command = [
        sys.executable,
        "-c",
        "from ecfit.cli import main; main()",
        "run",
        config,
        "--results",
        results,
    ]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=ENVIRONMENT
    )
    end = time.monotonic() + 120.0
    while time.monotonic() < end and not list(results.glob("small/fits/*.json")):
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert err.splitlines()[-1] == "stopped; what is finished is kept: the same command goes on from here"
    found = kills.files(results)
    assert any(name.startswith("small/fits/") for name in found)
    subprocess.run(command, check=True, capture_output=True, env=ENVIRONMENT)
    again = kills.files(results)
    assert {name: again[name] for name in found} == found
