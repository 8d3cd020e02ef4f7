"""The compilation cache: where it is, how it is switched off, and that it changes no number."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ecfit import _cache
from ecfit._cache import SWITCH, cache_folder, keep_compiled


@pytest.fixture
def no_jax(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if JAX had not loaded, with nothing said in the environment."""
    monkeypatch.setattr("sys.modules", {k: v for k, v in sys.modules.items() if k != "jax"})
    for name in ("JAX_COMPILATION_CACHE_DIR", SWITCH, *_cache._SETTINGS):
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
