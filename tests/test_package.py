"""The package: its public names, what they say of themselves, and that importing it does not load JAX."""

import ast
import importlib
import inspect
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import ecfit


def run(code: str, folder) -> str:
    found = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True
    )
    return found.stdout.strip()


@pytest.mark.parametrize(
    "statement",
    ["import ecfit", "import ecfit.config", "from ecfit.config import read_config", "import ecfit.cli"],
)
def test_importing_does_not_load_jax(statement, tmp_path):
    """So that a mistake in a config, and `ecfit --help`, need no second to answer."""
    assert run(f"import sys; {statement}; print('jax' in sys.modules)", tmp_path) == "False"


def test_computing_switches_jax_to_64_bits(tmp_path):
    assert (
        run("import ecfit.quadrature, jax.numpy as jnp; print(jnp.asarray(1.0).dtype)", tmp_path) == "float64"
    )


@pytest.mark.parametrize("name", [n for n in ecfit.__all__ if n != "__version__"])
def test_every_public_name_is_there_and_documented(name):
    assert getattr(ecfit, name).__doc__
    assert name in dir(ecfit)


def public() -> Iterator[tuple[str, Any]]:
    """(name, object) of every function and class that a package exports, and of their own methods."""
    root = Path(ecfit.__file__).parent
    packages = sorted(f"ecfit.{path.parent.name}" for path in root.glob("*/__init__.py"))
    found = {}
    for package in ("ecfit", *packages):
        module = importlib.import_module(package)
        for name in getattr(module, "__all__", vars(module)):
            thing = getattr(module, name)
            ours = getattr(thing, "__module__", "").startswith("ecfit.")
            if ours and not name.startswith("_") and (inspect.isfunction(thing) or inspect.isclass(thing)):
                found.setdefault(thing, f"{package}.{name}")
    for thing, name in found.items():
        yield name, thing
        for key in vars(thing) if inspect.isclass(thing) else ():
            if not key.startswith("_"):
                yield f"{name}.{key}", getattr(thing, key)


CONSTRUCTORS = ("__init__", "__post_init__", "__check_init__")


def raises_by_itself(thing: Any) -> bool:
    """Whether a function's own lines raise an `EcfitError`: not what it calls, which says so itself."""
    function = thing.fget if isinstance(thing, property) else inspect.unwrap(thing)
    if not inspect.isroutine(function) or not hasattr(function, "__code__"):
        return False
    if not Path(function.__code__.co_filename).is_file():  # made by `dataclass`
        return False
    called = [
        node.exc.func
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function))))
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call)
    ]
    return any(isinstance(f, ast.Name) and f.id in ("EcfitError", "unknown") for f in called)


def test_the_check_of_docstrings_sees_what_raises():
    assert raises_by_itself(ecfit.BSDF.check_range)
    assert raises_by_itself(ecfit.Fit.from_dict)
    assert raises_by_itself(vars(ecfit.Axis)["__post_init__"])
    assert not raises_by_itself(ecfit.furnace)
    names = {name for name, _ in public()}
    assert {"ecfit.fit", "ecfit.Fit.save", "ecfit.report.plot_table"} <= names
    assert len(names) > 500


def test_whatever_is_public_and_can_be_called_is_documented_with_its_errors():
    """`inspect.getdoc`: a method that overrides another may leave it to that one to say what it does."""
    silent, surprising = [], []
    for name, thing in public():
        if not (inspect.isclass(thing) or inspect.isroutine(thing) or isinstance(thing, property)):
            continue
        said = inspect.getdoc(thing) or ""
        if not said:
            silent.append(name)
        # What making an object raises is said by its class.
        made = (
            [vars(thing)[n] for n in CONSTRUCTORS if n in vars(thing)] if inspect.isclass(thing) else [thing]
        )
        said += "".join(inspect.getdoc(f) or "" for f in made if f is not thing)
        if any(map(raises_by_itself, made)) and "EcfitError" not in said:
            surprising.append(name)
    assert (silent, surprising) == ([], [])


def test_the_version_is_that_of_the_distribution():
    from importlib.metadata import version

    assert ecfit.__version__ == version("ecfit")


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'tabulat'"):
        _ = ecfit.tabulat  # type: ignore[attr-defined]
