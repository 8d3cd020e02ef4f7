"""Plugins travel as text, and the one that a study names is the one that computes."""

import importlib
import pickle
import sys
from pathlib import Path

import pytest

from ecfit.bsdf.registry import models
from ecfit.errors import EcfitError
from ecfit.study.plugins import Plugin, load_plugins, load_read, read_plugins

TEXT = """
import ecfit

VALUE = {value}

@ecfit.register("test-plugin-lobe")
class Lobe(ecfit.BSDF):
    value = VALUE

    def f(self, wo, wi):
        return 0.0
"""


def value() -> int:
    return models()["test-plugin-lobe"].value  # type: ignore[attr-defined]


def test_reading_imports_nothing(tmp_path: Path):
    (tmp_path / "a.py").write_text("raise RuntimeError('imported')")
    (read,) = read_plugins(["a.py"], tmp_path)
    assert read.text == b"raise RuntimeError('imported')"
    with pytest.raises(EcfitError, match=r"^plugin 'a.py' failed to import: RuntimeError: imported$"):
        load_read((read,))
    with pytest.raises(EcfitError, match="no such file next to the config"):
        read_plugins(["b.py"], tmp_path)


def test_a_worker_needs_no_file(tmp_path: Path):
    (tmp_path / "a.py").write_text(TEXT.format(value=1))
    sent = pickle.dumps(read_plugins(["a.py"], tmp_path))
    (tmp_path / "a.py").unlink()
    load_read(pickle.loads(sent))
    assert value() == 1


def test_a_text_that_changed_is_loaded_again_and_no_other(tmp_path: Path):
    path = tmp_path / "a.py"
    path.write_text(TEXT.format(value=1))
    load_plugins(["a.py"], tmp_path)
    first = models()["test-plugin-lobe"]
    load_plugins(["a.py"], tmp_path)
    load_plugins([], tmp_path)
    assert models()["test-plugin-lobe"] is first
    path.write_text(TEXT.format(value=2))
    load_plugins(["a.py"], tmp_path)
    assert value() == 2


def test_the_plugin_loaded_last_has_its_names(tmp_path: Path):
    for name, number in (("a.py", 1), ("b.py", 2)):
        (tmp_path / name).write_text(TEXT.format(value=number))
    for name, number in (("a.py", 1), ("b.py", 2), ("a.py", 1)):
        load_plugins([name], tmp_path)
        assert value() == number


def test_classes_of_a_plugin_can_be_sent(tmp_path: Path):
    (tmp_path / "a.py").write_text(TEXT.format(value=1))
    (plugin,) = load_plugins(["a.py"], tmp_path)
    assert pickle.loads(pickle.dumps(models()["test-plugin-lobe"])).value == 1
    assert Plugin("json").path is None
    load_read((plugin, Plugin("json")))
    assert "json" in sys.modules


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a module in a package that Python finds by its name."""
    package = tmp_path / "test_plugin_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "lobes.py").write_text(TEXT.format(value=1))
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in ("test_plugin_package", "test_plugin_package.lobes"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return package / "lobes.py"


def test_a_module_that_changed_is_refused_until_it_is_loaded_again(module: Path):
    names, base = ["test_plugin_package.lobes"], module.parent
    first = read_plugins(names, base)
    assert not set(sys.modules) & {"test_plugin_package", "test_plugin_package.lobes"}
    load_read(first)
    module.write_text(TEXT.format(value=22))  # of another length: Python's cache looks at that
    for _ in range(2):
        with pytest.raises(
            EcfitError, match=r"^plugin '.*lobes' changed since it was loaded: restart Python"
        ):
            load_plugins(names, base)
    assert value() == 1
    load_read(first)  # what is in memory may be used as what it is
    importlib.reload(sys.modules["test_plugin_package.lobes"])
    load_plugins(names, base)
    assert value() == 22
    with pytest.raises(EcfitError, match="changed since it was loaded"):
        load_read(pickle.loads(pickle.dumps(first)))  # a worker that has another


def test_a_package_is_all_of_its_files(module: Path):
    names, base = ["test_plugin_package"], module.parent
    load_plugins(names, base)
    module.write_text(TEXT.format(value=22))
    with pytest.raises(EcfitError, match="changed since it was loaded"):
        load_plugins(names, base)


@pytest.mark.parametrize("name", ["", ".", "a..b", "nowhere", "json.nowhere", "sys.x", "a\0b", "\udc80"])
def test_a_name_that_is_no_module_is_told_when_it_is_loaded(name: str, tmp_path: Path):
    (read,) = read_plugins([name], tmp_path)
    assert read == Plugin(name)
    with pytest.raises(EcfitError, match="failed to import"):
        read.load()
