"""What XLA compiles is kept in the user's cache folder, so that the next command does not compile it again.

Commands only: who imports ecfit keeps JAX as it is. No JAX here: it reads these variables when it loads.
"""

import hashlib
import os
import platform
import sys
from pathlib import Path

# Off, or a folder of the user's choice.
SWITCH = "ECFIT_COMPILATION_CACHE"
_FOLDER = "JAX_COMPILATION_CACHE_DIR"
# By default JAX keeps what took a second or more to compile, which none of ours does.
_SETTINGS = {
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
}


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
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
        able = next((line for line in lines if line.startswith(("flags", "Features"))), "")
    except OSError:
        able = platform.processor()
    text = "\n".join([platform.machine(), able, os.environ.get("XLA_FLAGS", "")])
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def keep_compiled() -> None:
    """Tell JAX, and that of processes started later, where to keep what is compiled.

    Nothing is changed where JAX has loaded, where the user told JAX a folder, and where it cannot be written.
    """
    if "jax" in sys.modules or _FOLDER in os.environ:
        return
    folder = cache_folder()
    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        os.environ[_FOLDER] = str(folder)
        for name, value in _SETTINGS.items():
            os.environ.setdefault(name, value)
