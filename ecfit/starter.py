"""A study file to start from, and the files of the studies that come with ecfit, as package data."""

import re
from importlib import resources
from pathlib import Path

from ecfit.errors import EcfitError, unknown
from ecfit.files import read_text, write_text

# What `ecfit.config` allows as the name of a study.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,79}")


def configs() -> dict[str, Path]:
    """Files of studies and furnaces that come with ecfit, by name; "starter" is for a beginning."""
    package = Path(str(resources.files("ecfit")))
    installed = package / "data" / "configs"
    # A wheel holds them as package data; a repository has them beside the package.
    folder = installed if installed.is_dir() else package.parent / "configs"
    found = {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {"starter": package / "data" / "starter.toml", **found}


def command_for(path: Path) -> str:
    """The command that takes such a file: "furnace" for a furnace, else "run"."""
    return "furnace" if "[[materials]]" in read_text(path) else "run"


def write_config(output: str | Path, like: str = "starter") -> Path:
    """Write the study file `like` to `output`, named after it, and return where it is.

    Raises `EcfitError` for a name that is not in `configs()`, for an output that exists, and for one whose
    name cannot be that of a study.
    """
    path = Path(output)
    known = configs()
    if like not in known:
        raise unknown("study", like, known)
    if path.suffix != ".toml":
        raise EcfitError(f"a study file ends in .toml: write '{path}.toml'?")
    if not _NAME.fullmatch(path.stem):
        raise EcfitError(f"'{path.stem}' cannot name a study: use letters, digits, '.', '_' and '-'")
    if path.exists() or path.is_symlink():
        raise EcfitError(f"'{path}' exists: choose another name, or delete it first")
    text = re.sub(r'^name = ".*"$', f'name = "{path.stem}"', read_text(known[like]), count=1, flags=re.M)
    write_text(path, text)
    return path
