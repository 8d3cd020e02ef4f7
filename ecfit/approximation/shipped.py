"""Shipped fits: our best approximations by budget, as package data with certificate and provenance.

One JSON file a fit in `ecfit/data/shipped`, written by `configs/best.toml` and `ecfit ship`. A name and its
coefficients never change once released; a better fit gets a new name.
"""

from importlib import resources
from pathlib import Path
from typing import overload

from ecfit.approximation.approximation import Approximation
from ecfit.errors import unknown
from ecfit.files import read_json


def shipped_folder() -> Path:
    """Where the files are."""
    return Path(str(resources.files("ecfit"))) / "data" / "shipped"


@overload
def shipped() -> list[str]: ...
@overload
def shipped(name: str) -> Approximation: ...
def shipped(name: str | None = None) -> list[str] | Approximation:
    """The names of all shipped fits, or one of them by name, evaluated like any approximation.

    `ecfit.shipped("conductor-10")(mu=0.5, r=0.3)`. Raises `EcfitError` for an unknown name.
    """
    names = sorted(path.stem for path in shipped_folder().glob("*.json"))
    if name is None:
        return names
    if name not in names:
        raise unknown("shipped fit", name, names)
    return Approximation.from_dict(read_json(shipped_folder() / f"{name}.json"), f"shipped fit '{name}'")
