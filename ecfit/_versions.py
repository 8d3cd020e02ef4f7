"""Versions of what computes numbers. No JAX here."""

import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version

# What the last bit of a table or fit depends on, beside ecfit and the processor.
PACKAGES = ("equinox", "jax", "jaxlib", "lineax", "numpy", "optimistix", "scipy")


def versions() -> dict[str, str]:
    """Versions of ecfit, Python and `PACKAGES`, of those that are installed."""
    found = {}
    for name in ("ecfit", *PACKAGES):
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return {**found, "python": platform.python_version()}
