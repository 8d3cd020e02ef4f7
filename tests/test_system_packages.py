"""`make system`: what it asks apt-get for, and what it says where that cannot help."""

import shutil
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / ".ci/system"
BASH = shutil.which("bash")
pytestmark = pytest.mark.skipif(BASH is None, reason="no bash")

# None of the packages is installed, and there is root; apt-get writes down what it is asked for.
FAKES = {
    "dpkg-query": "exit 1",
    "id": "echo 0",
    "apt-get": 'echo "$*" >> "$LOG"; case "$*" in *"$REFUSED"*) exit 100 ;; esac',
}


def run(tmp_path, fakes, refused="nothing", path="/usr/bin:/bin"):
    """The script's exit code, what it says, and the calls of apt-get, with false commands in the path."""
    folder, log = tmp_path / "bin", tmp_path / "log"
    folder.mkdir()
    for name in fakes:
        (folder / name).write_text(f"#!{BASH}\n{FAKES[name]}\n")
        (folder / name).chmod(0o755)
    environment = {"PATH": f"{folder}:{path}", "LOG": str(log), "REFUSED": refused}
    done = subprocess.run([str(BASH), str(SCRIPT)], capture_output=True, text=True, env=environment)
    calls = log.read_text().splitlines() if log.exists() else []
    return done.returncode, done.stdout + done.stderr, calls


def test_the_browser_is_asked_for_apart(tmp_path):
    code, said, calls = run(tmp_path, FAKES)
    assert code == 0, said
    assert [call.split()[0] for call in calls] == ["update", "install", "install"]
    assert " gcc " in calls[1]
    assert "chromium" not in calls[1]
    assert calls[2].endswith(" chromium chromium-driver")
    assert said.count("system packages: installed") == 2


def test_a_system_without_the_browser_still_gets_the_compilers(tmp_path):
    """Ubuntu has no chromium-driver: apt-get then installs nothing of what is in one call with it."""
    code, said, calls = run(tmp_path, FAKES, refused="chromium-driver")
    assert code == 0, said
    assert len(calls) == 3
    assert "installed gcc" in said
    assert "installed chromium" not in said
    assert "no chromium chromium-driver here" in said


def test_compilers_that_cannot_be_had_are_a_failure(tmp_path):
    code, said, _ = run(tmp_path, FAKES, refused="gcc")
    assert code != 0
    assert "installed" not in said


@pytest.mark.parametrize("absent", ["dpkg-query", "apt-get"])
def test_no_debian_is_told_by_either_command(tmp_path, absent):
    code, said, calls = run(tmp_path, {*FAKES} - {absent}, path="")
    assert (code, calls) == (1, [])
    assert "no Debian here" in said
