"""Which of Mitsuba's variants to render with: compiled by LLVM where that runs, else the scalar one."""

import os
import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ecfit.rendering._mitsuba import mitsuba

FAST, SLOW = "llvm_ad_rgb", "scalar_rgb"
# Where Dr.Jit is told which LLVM to load.
LIBRARY = "DRJIT_LIBLLVM_PATH"
# Dr.Jit 1.x aborts the process with LLVM 15 and 16, and does not start with older ones.
_OLDEST = 17
_FOLDERS = (
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/opt/homebrew/opt/llvm/lib",
    "/usr/local/opt/llvm/lib",
)
_PROBE = (
    "import mitsuba, drjit; mitsuba.set_variant('llvm_ad_rgb'); print(int(drjit.sum(mitsuba.Float(1, 2))[0]))"
)


@dataclass(frozen=True)
class Variant:
    """How to render: the variant's name, what the environment needs, and what there is to say about it."""

    name: str
    environment: Mapping[str, str]
    remark: str = ""


def choose() -> Variant:
    """The fastest variant that works here, tried in a process of its own, as a wrong LLVM ends it.

    Raises `EcfitError` where Mitsuba is not installed.
    """
    mitsuba()
    for library in _libraries():
        environment = {LIBRARY: library} if library else {}
        if _works(environment):
            return Variant(FAST, environment)
    remark = (
        f"no LLVM {_OLDEST} or newer was found (Debian: apt-get install libllvm19; elsewhere set {LIBRARY}): "
        "rendering in scalar mode, about 1000 times slower"
    )
    return Variant(SLOW, {}, remark)


def _libraries() -> list[str]:
    """Libraries to try: the one that the environment names, then what is found."""
    if os.environ.get(LIBRARY):
        return [os.environ[LIBRARY]]
    found: dict[int, str] = {}
    for folder in _FOLDERS:
        for path in sorted(Path(folder).glob("**/libLLVM*")) if Path(folder).is_dir() else ():
            version = re.search(r"libLLVM(?:-|\.so\.)(\d+)", path.name)
            if version and int(version[1]) >= _OLDEST:
                found.setdefault(int(version[1]), str(path))
    # 19 is the version that is tested here.
    return [found[v] for v in sorted(found, key=lambda v: (v != 19, -v))]


def _works(environment: Mapping[str, str]) -> bool:
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=120,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0 and done.stdout.strip() == "3"
