"""What XLA compiles is kept in the user's cache folder, so that the next command does not compile it again.

Commands only: who imports ecfit keeps JAX as it is. No JAX here: it reads these variables when it loads.
"""

import hashlib
import os
import platform
import re
import sys
import time
import warnings
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from ecfit._processor import abilities

# Off, or a folder of the user's choice.
SWITCH = "ECFIT_COMPILATION_CACHE"
_FOLDER = "JAX_COMPILATION_CACHE_DIR"
# By default JAX keeps what took a second or more to compile, which none of ours does.
_SETTINGS = {
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
}
# What JAX says of entries that are half there (another process is writing it, or was killed while it did) and
# of disks that are full. It compiles instead: nobody has to know.
_UNSAID = ("Error reading persistent compilation cache", "Error writing persistent compilation cache")

# Names of JAX's entries; nothing else is ever removed.
_ENTRY = re.compile(r".+-[0-9a-f]{64}-cache")
# Bytes that the folders of all processors may hold: a study leaves 5 to 20 MB. JAX's own limit
# (JAX_COMPILATION_CACHE_MAX_SIZE) needs a package for locks, and a lock at every entry.
LIMIT = 500_000_000
# Seconds between two sweeps.
_DAY = 86_400.0
# An entry that is younger may still be written.
_MINUTE = 60.0


def cache_folder() -> Path | None:
    """The folder: `$XDG_CACHE_HOME/ecfit/...` (`~/.cache` by default), what the switch says, or none.

    One a processor: compiled code uses the instructions of the one that it was compiled on, and a home may
    be shared by several.
    """
    said = os.environ.get(SWITCH, "").strip()
    if said.lower() in ("off", "0", "no", "false"):
        return None
    if said and said.lower() not in ("on", "1", "yes", "true"):
        return Path(said)
    base = os.environ.get("XDG_CACHE_HOME", "")
    try:
        root = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
    except RuntimeError:  # a user without a home
        return None
    return root / "ecfit" / f"xla-{_processor()}"


def _processor() -> str:
    """A hash of what this processor can do, and of the flags that XLA is told."""
    text = "\n".join([platform.machine(), abilities(), os.environ.get("XLA_FLAGS", "")])
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def keep_compiled() -> None:
    """Tell JAX, and that of processes started later, where to keep what is compiled.

    Nothing is changed where JAX has loaded, where the user told JAX a folder, and where the folder cannot be
    written, or by others too: what is in it is executed.
    Whatever is wrong with the folder later, JAX compiles.
    """
    if "jax" in sys.modules or _FOLDER in os.environ:
        return
    folder = cache_folder()
    if folder is None:
        return
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not (os.access(folder, os.W_OK) and _private(folder)):
            return
    except OSError:
        return
    os.environ[_FOLDER] = str(folder)
    for name, value in _SETTINGS.items():
        os.environ.setdefault(name, value)
    for message in _UNSAID:
        warnings.filterwarnings("ignore", message)
    said = [os.environ.get("PYTHONWARNINGS", ""), *(f"ignore:{message}" for message in _UNSAID)]
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, said))  # of workers
    sweep(folder)


def _private(folder: Path) -> bool:
    """Whether nobody else may write there, as far as the system tells."""
    if not hasattr(os, "getuid"):
        return True
    found = folder.stat()
    return found.st_uid == os.getuid() and not found.st_mode & 0o022


def sweep(folder: Path) -> None:
    """Once a day: remove entries that were never finished, and the oldest of too many; never an error.

    JAX does neither: an entry that a killed process left half-written would be compiled again each time.
    """
    stamp = folder / ".swept"
    with suppress(OSError):
        last = stamp.stat().st_mtime if stamp.exists() else 0.0
        if time.time() - last < _DAY:
            return
        stamp.touch()
        # Read last (to a day, as most systems keep it), or written.
        found = sorted((max(s.st_atime, s.st_mtime), s.st_size, path) for path, s in _entries(folder))
        total = sum(size for _, size, _ in found)
        for _, size, path in found:
            fresh = path.stat().st_mtime > last - _MINUTE
            if total > LIMIT or (fresh and not _whole(path)):
                path.unlink(missing_ok=True)
                total -= size


def _entries(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    """The entries of a folder and, where it is ours, of its neighbours: other processors and flags."""
    ours = folder.name.startswith("xla-") and Path(os.environ.get(SWITCH, "").strip()) != folder
    folders = [near for near in folder.parent.glob("xla-*") if near.is_dir()] if ours else [folder]
    for path in (path for near in folders for path in near.iterdir()):
        if _ENTRY.fullmatch(path.name):
            with suppress(FileNotFoundError):  # another process may sweep, too
                yield path, path.stat()


def _whole(path: Path) -> bool:
    """Whether an entry can be unpacked, or is too young to say."""
    content = path.read_bytes()
    if time.time() - path.stat().st_mtime < _MINUTE:
        return True
    if content and content[0] != 0x78:  # not of zlib: JAX takes zstd where that is installed
        return True
    try:
        zlib.decompress(content)
    except zlib.error:
        return False
    return True
