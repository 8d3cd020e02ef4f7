"""A user's modules that register models: only those that a config or command names are imported."""

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path

from ecfit.errors import EcfitError


@dataclass(frozen=True)
class Plugin:
    """A module of a user: one that Python finds by its name, or a file.

    The text of a file goes along to workers, which need not see the file and, where they outlive a study, may
    have an older one in memory. Of a module only a hash goes along, so that a process with other code says
    so: Python imports a module once.

    Attributes:
        name: as the config or command gives it.
        path: of a file; None for a module.
        text: of a file.
        digest: SHA-256 of a module's source on disk (of a package: of all of it); empty, and not
            compared, where it has none.
    """

    name: str
    path: Path | None = None
    text: bytes = b""
    digest: str = ""

    def load(self) -> None:
        """Import the module; raises `EcfitError` where that fails, and where other code is in memory."""
        try:
            if self.path is None:
                loaded = _imported(self.name)
            else:
                self._execute(self.path)
                loaded = ""
        except EcfitError:
            raise
        # Whatever the user's module raises is reported as its fault; a script that ends itself does, too.
        except (Exception, SystemExit) as error:
            raise EcfitError(
                f"plugin '{self.name}' failed to import: {type(error).__name__}: {error}"
            ) from error
        if self.digest and loaded != self.digest:
            raise EcfitError(
                f"plugin '{self.name}' changed since it was loaded: restart Python (on a cluster "
                "the workers, too, with the same files)"
            )

    def _execute(self, path: Path) -> None:
        # By its path, so that a worker finds the classes of what is sent to it under the same name.
        module_name = f"ecfit_plugin_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"
        spec = importlib.util.spec_from_file_location(module_name, path)
        assert spec is not None  # its name ends in .py
        module = importlib.util.module_from_spec(spec)
        sys.modules[module_name] = module
        try:
            exec(compile(self.text, str(path), "exec", dont_inherit=True), module.__dict__)
        except BaseException:
            del sys.modules[module_name]
            raise


# Modules that were imported here: what Python found, which a reload replaces, and the hash of that source.
_sources: dict[str, tuple[ModuleSpec | None, str]] = {}


def _imported(name: str) -> str:
    """Import a module by its name; the hash of the source that is in memory.

    Of one that somebody else had imported before it is the source on disk when it is first asked for.
    """
    digest = _source_digest(name)
    module = importlib.import_module(name)
    known = _sources.get(name)
    if known is None or known[0] is not module.__spec__:
        known = _sources[name] = module.__spec__, digest
    return known[1]


def _source_digest(name: str) -> str:
    """The hash of a module's source on disk, found without importing anything; see `Plugin.digest`."""
    digest = hashlib.sha256()
    # A name that no module can have is told when it is imported.
    with suppress(Exception):
        spec = _spec(name)
        if spec is not None and spec.submodule_search_locations is not None:
            for folder in map(Path, spec.submodule_search_locations):
                for path in sorted(folder.rglob("*.py")):
                    digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
            return digest.hexdigest()
        if spec is not None and spec.origin is not None and spec.origin.endswith(".py"):
            digest.update(Path(spec.origin).read_bytes())
            return digest.hexdigest()
    return ""


def _spec(name: str) -> ModuleSpec | None:
    """Where Python finds a module. `importlib.util.find_spec` would import the packages that it is in."""
    first, *rest = name.split(".")
    importlib.invalidate_caches()  # a file may be younger than what the finders remember of its folder
    spec = importlib.util.find_spec(first)
    for part in rest:
        if spec is None or spec.submodule_search_locations is None:
            return None
        first = f"{first}.{part}"
        spec = PathFinder.find_spec(first, spec.submodule_search_locations)
    return spec


def read_plugins(names: Iterable[str], base: Path) -> tuple[Plugin, ...]:
    """The plugins of some names: Python files (relative to `base`) or dotted modules. Imports nothing.

    Raises `EcfitError` where a file does not exist.
    """
    return tuple(_read(name, base) for name in names)


def _read(name: str, base: Path) -> Plugin:
    if not name.endswith(".py"):
        return Plugin(name, digest=_source_digest(name))
    if "\0" in name:  # no system call takes one
        raise EcfitError(f"plugin {name!r}: no file has such a name")
    path = (base / name).resolve()
    if not path.is_file():
        raise EcfitError(f"plugin '{name}': no such file next to the config ('{path}')")
    try:
        return Plugin(name, path, path.read_bytes())
    except OSError as error:
        raise EcfitError(f"cannot read the plugin '{path}': {error.strerror or error}") from None


# What was loaded last: plugins that were loaded before it may share its names, and have to be loaded again.
_loaded: tuple[Plugin, ...] = ()


def load_read(plugins: tuple[Plugin, ...]) -> None:
    """Import all plugins, in order; files again where others, or other texts, were loaded in between.

    Modules are imported once, as Python does: what they register stays as it is until something else takes
    the name. Raises `EcfitError` where one fails to import, or a module changed since it was imported.
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

    Raises `EcfitError` where one does not exist or fails to import, or a module changed since its import.
    """
    plugins = read_plugins(names, base)
    load_read(plugins)
    return plugins
