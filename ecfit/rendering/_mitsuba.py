"""Mitsuba 3 and Dr.Jit, an optional extra. Modules that define its plugins take them from here."""

from importlib import import_module
from typing import Any

from ecfit.errors import EcfitError

REMEDY = "pictures are rendered by Mitsuba 3, which is not installed: pip install 'ecfit[render]'"


def mitsuba() -> tuple[Any, Any]:
    """The modules `mitsuba` and `drjit`. Raises `EcfitError` where they are not installed."""
    try:
        return import_module("mitsuba"), import_module("drjit")
    except ImportError:
        raise EcfitError(REMEDY) from None
