"""Published fits, registered as data: one JSON file a source in `ecfit/data/published`."""

from importlib import resources
from pathlib import Path

from ecfit.approximation.approximation import Approximation
from ecfit.errors import unknown
from ecfit.files import read_json


def _folder() -> Path:
    return Path(str(resources.files("ecfit"))) / "data" / "published"


def published_names() -> list[str]:
    """Names that `published` accepts."""
    return sorted(path.stem for path in _folder().glob("*.json"))


def published(name: str) -> Approximation:
    """A published approximation by name, evaluated like any other.

    Raises `EcfitError` for an unknown name (it lists the known ones).
    """
    if name not in published_names():
        raise unknown("published fit", name, published_names())
    return Approximation.from_dict(read_json(_folder() / f"{name}.json"), f"published fit '{name}'")


def find(name: str) -> Approximation:
    """An approximation by a published name or from a file (`*.json`, written by a fit or a study).

    Raises `EcfitError` for an unknown name and a file that is missing or holds something else.
    """
    if not name.endswith(".json"):
        return published(name)
    return Approximation.from_dict(read_json(Path(name)), f"'{name}'")
