"""The compilation cache: where it is, how it is switched off, and that it changes no number."""

import os
import subprocess
import sys
import time
import zlib
from pathlib import Path

import pytest

from ecfit import _cache
from ecfit._cache import SWITCH, cache_folder, keep_compiled, sweep


@pytest.fixture
def no_jax(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if JAX had not loaded, with nothing said in the environment."""
    monkeypatch.setattr("sys.modules", {k: v for k, v in sys.modules.items() if k != "jax"})
    for name in ("JAX_COMPILATION_CACHE_DIR", "PYTHONWARNINGS", SWITCH, *_cache._SETTINGS):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)


@pytest.mark.usefixtures("no_jax")
def test_it_is_in_the_users_cache_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    keep_compiled()
    folder = Path(os.environ["JAX_COMPILATION_CACHE_DIR"])
    assert folder.is_dir()
    assert folder.parent == tmp_path / "ecfit"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # to be ignored, says the standard
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    found = cache_folder()
    assert found is not None
    assert found.parent == tmp_path / "home" / ".cache" / "ecfit"


@pytest.mark.usefixtures("no_jax")
def test_other_flags_of_xla_have_another_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    before = cache_folder()
    monkeypatch.setenv("XLA_FLAGS", "--xla_cpu_max_isa=SSE4_2")
    assert cache_folder() != before


@pytest.mark.parametrize("word", ["off", "0", "No", "false"])
@pytest.mark.usefixtures("no_jax")
def test_it_can_be_switched_off(monkeypatch: pytest.MonkeyPatch, word: str):
    monkeypatch.setenv(SWITCH, word)
    keep_compiled()
    assert "JAX_COMPILATION_CACHE_DIR" not in os.environ


@pytest.mark.usefixtures("no_jax")
def test_what_the_user_says_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(SWITCH, str(tmp_path / "mine"))
    keep_compiled()
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == str(tmp_path / "mine")
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "/theirs")
    keep_compiled()
    assert os.environ["JAX_COMPILATION_CACHE_DIR"] == "/theirs"


@pytest.mark.usefixtures("no_jax")
def test_a_folder_that_cannot_be_made_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(SWITCH, str(tmp_path / "file" / "cache"))
    keep_compiled()
    assert "JAX_COMPILATION_CACHE_DIR" not in os.environ


def test_a_process_that_has_jax_keeps_it_as_it_is(monkeypatch: pytest.MonkeyPatch):
    import jax

    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR", raising=False)
    keep_compiled()
    assert jax.config.jax_compilation_cache_dir is None
    assert "JAX_COMPILATION_CACHE_DIR" not in os.environ


@pytest.mark.usefixtures("no_jax")
def test_a_folder_that_may_only_be_read_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(SWITCH, str(tmp_path))
    monkeypatch.setattr("os.access", lambda *_: False)  # root may write whatever the mode says
    keep_compiled()
    assert "JAX_COMPILATION_CACHE_DIR" not in os.environ


@pytest.mark.usefixtures("no_jax")
@pytest.mark.skipif(os.name != "posix", reason="modes of POSIX")
def test_the_folder_is_the_users_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    keep_compiled()
    assert Path(os.environ["JAX_COMPILATION_CACHE_DIR"]).stat().st_mode & 0o777 == 0o700


def entry(folder: Path, name: str, content: bytes, age: float) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / f"jit_{name}-{'0a' * 32}-cache"
    path.write_bytes(content)
    os.utime(path, (time.time() - age,) * 2)
    return path


GOOD = zlib.compress(bytes(range(256)) * 8)
HOUR = 3600.0


def test_a_sweep_removes_what_was_never_finished(tmp_path: Path):
    good = entry(tmp_path, "good", GOOD, HOUR)
    zstd = entry(tmp_path, "zstd", b"\x28\xb5\x2f\xfd", HOUR)
    half = entry(tmp_path, "half", GOOD[:-5], HOUR)
    empty = entry(tmp_path, "empty", b"", HOUR)
    young = entry(tmp_path, "young", GOOD[:-5], 1.0)
    other = tmp_path / "half-cache"
    other.write_bytes(GOOD[:-5])
    os.utime(other, (0, 0))
    sweep(tmp_path)
    assert sorted(tmp_path.glob("*-cache")) == sorted([good, zstd, young, other])
    entry(tmp_path, "half", b"", HOUR)
    sweep(tmp_path)
    assert half.exists()  # once a day
    os.utime(tmp_path / ".swept", (time.time() - 25 * HOUR,) * 2)
    sweep(tmp_path)
    assert not half.exists()
    assert not empty.exists()


def test_a_sweep_keeps_the_latest_of_all_processors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(_cache, "LIMIT", 2.5 * len(GOOD))
    one, two = tmp_path / "xla-1", tmp_path / "xla-2"
    aged = [entry(one if i % 2 else two, str(i), GOOD, (5 - i) * HOUR) for i in range(5)]
    (tmp_path / "theirs").mkdir()
    theirs = entry(tmp_path / "theirs", "9", GOOD, 100 * HOUR)
    sweep(one)
    assert [path.exists() for path in aged] == [False, False, False, True, True]
    assert theirs.exists()


def test_a_folder_that_the_user_chose_is_swept_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(_cache, "LIMIT", 0)
    monkeypatch.setenv(SWITCH, str(tmp_path / "xla-mine"))
    (tmp_path / "xla-notes").write_text("no folder")
    mine, theirs = (entry(tmp_path / name, "1", GOOD, HOUR) for name in ("xla-mine", "xla-theirs"))
    sweep(tmp_path / "xla-mine")
    assert (mine.exists(), theirs.exists()) == (False, True)


@pytest.mark.usefixtures("no_jax")
@pytest.mark.skipif(not hasattr(os, "getuid"), reason="the system tells no owners")
def test_a_folder_that_others_may_write_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What is in it is executed."""
    tmp_path.chmod(0o777)
    monkeypatch.setenv(SWITCH, str(tmp_path))
    keep_compiled()
    assert "JAX_COMPILATION_CACHE_DIR" not in os.environ


def test_a_folder_that_is_gone_is_no_error(tmp_path: Path):
    sweep(tmp_path / "nowhere")


def compiled(folder: Path, start: str = "") -> subprocess.Popen[str]:
    """A process that compiles and prints a sum, as commands do with the folder."""
    code = (
        f"{start}\nfrom ecfit._cache import keep_compiled\nkeep_compiled()\n"
        "import jax, jax.numpy as jnp\nprint(jax.jit(lambda x: (x * x).sum())(jnp.arange(4.0)))"
    )
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "PYTHONWARNINGS"))}
    return subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**kept, SWITCH: str(folder)},
    )


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_damaged_entries_full_disks_and_processes_at_once_are_no_matter(tmp_path: Path):
    """Entries that are cut, emptied, or changed in the middle; files that may have no more than 100 bytes."""
    for process in [compiled(tmp_path), compiled(tmp_path)]:
        assert process.communicate(timeout=300) == ("14.0\n", "")
    entries = sorted(tmp_path.glob("*-cache"))
    assert len(entries) >= 1
    for i, path in enumerate(entries):
        good = path.read_bytes()
        middle = good[: len(good) // 2] + b"\xff" * 9 + good[len(good) // 2 + 9 :]
        path.write_bytes([good[: len(good) // 3], b"", middle][i % 3])
    full = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))"
    for process in [compiled(tmp_path), compiled(tmp_path / "full", full)]:
        assert process.communicate(timeout=300) == ("14.0\n", "")
    assert all(path.stat().st_size <= 100 for path in (tmp_path / "full").glob("*-cache"))


@pytest.mark.slow
def test_cached_and_compiled_code_give_the_same_bytes(tmp_path: Path):
    """Three runs: without a cache, filling it, and from it."""
    found = []
    for switch in ("off", str(tmp_path / "cache"), str(tmp_path / "cache")):
        output = tmp_path / f"{len(found)}.json"
        program = (
            "from ecfit.cli import main\n"
            f"main(['table', 'conductor', '--axis', 'r=8', '--axis', 'mu=8', '--output', '{tmp_path}/t.npz'])"
        )
        fit = (
            "from ecfit.cli import main\n"
            f"main(['fit', '{tmp_path}/t.npz', '--degree', '2', '--output', '{output}'])"
        )
        for text in (program, fit):
            code = f"try:\n exec({text!r})\nexcept SystemExit as stop:\n assert not stop.code"
            subprocess.run(
                [sys.executable, "-c", code],
                check=True,
                env={**os.environ, SWITCH: switch},
                capture_output=True,
            )
        found.append(output.read_bytes())
    assert len(list((tmp_path / "cache").iterdir())) > 10
    assert found[0] == found[1] == found[2]
