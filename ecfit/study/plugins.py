"""A user's modules that register models: only those that a config or command names are imported."""

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Iterable
from pathlib import Path

from ecfit.errors import EcfitError


def load_plugin(name: str, base: Path) -> None:
    """Import `name`: a Python file (relative to `base`) or a dotted module.

    Raises `EcfitError` where it does not exist or fails to import.
    """
    try:
        if name.endswith(".py"):
            path = (base / name).resolve()
            if not path.is_file():
                raise EcfitError(f"plugin '{name}': no such file next to the config ('{path}')")
            module_name = f"ecfit_plugin_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"
            if module_name in sys.modules:
                return
            spec = importlib.util.spec_from_file_location(module_name, path)
            if spec is None or spec.loader is None:
                raise EcfitError(f"plugin '{name}': not a Python file")
            module = importlib.util.module_from_spec(spec)
            sys.modules[module_name] = module
            try:
                spec.loader.exec_module(module)
            except BaseException:
                del sys.modules[module_name]
                raise
        else:
            importlib.import_module(name)
    except EcfitError:
        raise
    # Whatever the user's module raises is reported as its fault; a script that ends itself does, too.
    except (Exception, SystemExit) as error:
        raise EcfitError(f"plugin '{name}' failed to import: {type(error).__name__}: {error}") from error


def load_plugins(names: Iterable[str], base: Path) -> None:
    """Import all plugins, in order."""
    for name in names:
        load_plugin(name, base)
