"""The package: its public names, and that importing it does not load JAX."""

import subprocess
import sys

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


def test_the_version_is_that_of_the_distribution():
    from importlib.metadata import version

    assert ecfit.__version__ == version("ecfit")


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'tabulat'"):
        _ = ecfit.tabulat  # type: ignore[attr-defined]
