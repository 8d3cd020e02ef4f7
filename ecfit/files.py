"""Writing files so that a killed run leaves no half-written one, and reading them with clear errors."""

import json
import os
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from ecfit.errors import EcfitError


def make_folder(path: Path) -> Path:
    """Create a folder and its parents; raises `EcfitError` where that is not possible."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EcfitError(f"cannot create the folder '{path}': {error.strerror or error}") from None
    return path


def write_atomically(path: Path, write: Callable[[IO[bytes]], object]) -> None:
    """Write to a temporary name beside `path`, then rename; raises `EcfitError` on failure."""
    make_folder(path.parent)
    temporary = None
    try:
        with tempfile.NamedTemporaryFile(
            dir=path.parent, prefix=f".{path.name}.", suffix=".part", delete=False
        ) as file:
            temporary = file.name
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        raise EcfitError(f"cannot write '{path}': {error.strerror or error}") from None
    except BaseException:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        raise


# Seconds after which a temporary file is nobody's: writing one takes less, even of gigabytes on slow disks.
STALE = 3600.0


def clear_parts(folder: Path) -> None:
    """Remove temporary files that killed runs left in a folder; those of a run at work are younger."""
    for path in folder.glob(".*.part"):
        with suppress(OSError):  # another run may be faster
            if time.time() - path.stat().st_mtime > STALE:
                path.unlink()


def write_text(path: Path, text: str) -> None:
    """Write text (UTF-8) atomically."""
    write_atomically(path, lambda file: file.write(text.encode("utf-8")))


def write_json(path: Path, data: Any) -> None:
    """Write JSON atomically; NaN and infinity become null."""
    write_text(path, json.dumps(_finite(data), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {k: _finite(v) for k, v in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(v) for v in data]
    if isinstance(data, float) and not (-float("inf") < data < float("inf")):
        return None
    return data


def read_text(path: Path) -> str:
    """Read a UTF-8 text file; raises `EcfitError` where it is missing, unreadable or not text."""
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise EcfitError(f"no such file: '{path}'") from None
    except UnicodeDecodeError:
        raise EcfitError(f"'{path}' is not a text file in UTF-8") from None
    except OSError as error:
        raise EcfitError(f"cannot read '{path}': {error.strerror or error}") from None


def read_json(path: Path) -> Any:
    """Read a JSON file; raises `EcfitError` where it is missing or malformed."""
    try:
        return json.loads(read_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise EcfitError(f"'{path}' is not valid JSON: {error}") from None
    except ValueError:  # Python reads no longer ones
        raise EcfitError(f"'{path}' is not valid JSON: a whole number of thousands of digits") from None


@dataclass(frozen=True)
class Carried:
    """A file that goes along with a task: pickled, it is its bytes, for a worker that has none of our disks.

    Attributes:
        path: where it is, or was; messages name it.
        content: its bytes, where it has been pickled.
    """

    path: Path
    content: bytes | None = None

    def read(self) -> bytes:
        """The bytes of the file; raises `EcfitError` where it cannot be read."""
        if self.content is not None:
            return self.content
        try:
            return self.path.read_bytes()
        except OSError as error:
            raise EcfitError(f"cannot read '{self.path}': {error.strerror or error}") from None

    def __reduce__(self) -> tuple[Any, ...]:
        return Carried, (self.path, self.read())
