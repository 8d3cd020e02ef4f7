"""A user's modules that register models: only those that a config or command names are imported."""

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ecfit.errors import EcfitError


@dataclass(frozen=True)
class Plugin:
    """A module of a user: one that Python finds by its name, or a file, with its text.

    The text goes along to workers, which need not see the file and, where they outlive a study, may have an
    older one in memory.
    """

    name: str
    path: Path | None = None
    text: bytes = b""

    def load(self) -> None:
        """Import the module; raises `EcfitError` where that fails."""
        try:
            if self.path is None:
                importlib.import_module(self.name)
            else:
                self._execute(self.path)
        except EcfitError:
            raise
        # Whatever the user's module raises is reported as its fault; a script that ends itself does, too.
        except (Exception, SystemExit) as error:
            raise EcfitError(
                f"plugin '{self.name}' failed to import: {type(error).__name__}: {error}"
            ) from error

    def _execute(self, path: Path) -> None:
        # By its path, so that a worker finds the classes of what is sent to it under the same name.
        module_name = f"ecfit_plugin_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"
        spec = importlib.util.spec_from_file_location(module_name, path)
        if spec is None or spec.loader is None:
            raise EcfitError(f"plugin '{self.name}': not a Python file")
        module = importlib.util.module_from_spec(spec)
        sys.modules[module_name] = module
        try:
            exec(compile(self.text, str(path), "exec", dont_inherit=True), module.__dict__)
        except BaseException:
            del sys.modules[module_name]
            raise


def read_plugins(names: Iterable[str], base: Path) -> tuple[Plugin, ...]:
    """The plugins of some names: Python files (relative to `base`) or dotted modules. Imports nothing.

    Raises `EcfitError` where a file does not exist.
    """
    return tuple(_read(name, base) for name in names)


def _read(name: str, base: Path) -> Plugin:
    if not name.endswith(".py"):
        return Plugin(name)
    if "\0" in name:  # no system call takes one
        raise EcfitError(f"plugin {name!r}: no file has such a name")
    path = (base / name).resolve()
    if not path.is_file():
        raise EcfitError(f"plugin '{name}': no such file next to the config ('{path}')")
    try:
        return Plugin(name, path, path.read_bytes())
    except OSError as error:
        raise EcfitError(f"cannot read the plugin '{path}': {error.strerror or error}") from None


# What was loaded last. Others may have registered the same names since, or the same files be others now.
_loaded: tuple[Plugin, ...] = ()


def load_read(plugins: tuple[Plugin, ...]) -> None:
    """Import all plugins, in order; again where others, or other texts, were loaded in between.

    Raises `EcfitError` where one fails to import.
    """
    global _loaded
    if not plugins or plugins == _loaded:
        return
    _loaded = ()
    for plugin in plugins:
        plugin.load()
    _loaded = plugins


def load_plugins(names: Iterable[str], base: Path) -> tuple[Plugin, ...]:
    """Import the plugins of some names, in order, and return what was read; see `Plugin`.

    Raises `EcfitError` where one does not exist or fails to import.
    """
    plugins = read_plugins(names, base)
    load_read(plugins)
    return plugins
