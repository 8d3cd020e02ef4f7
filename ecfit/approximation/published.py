"""Published fits, registered as data: one JSON file a formula in `ecfit/data/published`.

Names say the source and often its year: "kulla-conty-2017". A source with several formulas has one name for
each: the plain one is E1, the directional albedo with F = 1; "-a" and "-b" are the weights of F0 and F90 in
E = F0 A + F90 B; "-average" is E_avg; "-leaving" is the other side of an interface. Conventions that a source
leaves open were settled by measuring: docs/published-conventions.md.
"""

from importlib import resources
from pathlib import Path

from ecfit.approximation.approximation import Approximation
from ecfit.approximation.shipped import shipped
from ecfit.errors import unknown
from ecfit.files import read_json


def _folder() -> Path:
    return Path(str(resources.files("ecfit"))) / "data" / "published"


def published_names() -> list[str]:
    """Names that `published` accepts."""
    return sorted(path.stem for path in _folder().glob("*.json"))


def published(name: str) -> Approximation:
    """A published approximation by name, evaluated like any other.

    `ecfit.published("kulla-conty-2017")(mu=0.3, r=0.5)`: coordinates in any view, arrays broadcast. What it
    approximates is its `contract`, where its authors made it for its `domain`, and who they are its `source`;
    `ecfit list` prints all names.

    Raises `EcfitError` for an unknown name (it lists the known ones).
    """
    if name not in published_names():
        raise unknown("published fit", name, published_names())
    return Approximation.from_dict(read_json(_folder() / f"{name}.json"), f"published fit '{name}'")


def find(name: str) -> Approximation:
    """An approximation by a shipped or published name, or from a JSON file of a fit or a study.

    Raises `EcfitError` for an unknown name and a file that is missing or holds something else.
    """
    if not name.endswith(".json"):
        if name in shipped():
            return shipped(name)
        if name not in published_names():
            raise unknown("shipped or published fit", name, [*shipped(), *published_names()])
        return published(name)
    return Approximation.from_dict(read_json(Path(name)), f"'{name}'")
