"""Compilers as data: what is called, how it tells its version, and what to install where it is missing."""

import importlib.util
import os
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ecfit.errors import EcfitError

# Seconds after which a compiler is taken to hang; the slowest here (slangc to a library) needs 20.
_PATIENCE = 300.0


@dataclass(frozen=True)
class Compiler:
    """A program that reads one file and writes another.

    Attributes:
        name: the executable; from the environment variable `variable` if that is set.
        install: what to do where it is missing.
        version: the argument that makes it print its version, or "" where there is none.
        variable: name of an environment variable, or "".
        package: a Python package that has it in its folder `bin`, or "".
    """

    name: str
    install: str
    version: str = "--version"
    variable: str = ""
    package: str = ""

    def path(self) -> str | None:
        """Where it is, or None."""
        found = shutil.which(os.environ.get(self.variable) or self.name)
        if found is None and self.package:
            spec = importlib.util.find_spec(self.package)
            if spec is not None and spec.origin is not None:
                found = shutil.which(str(Path(spec.origin).parent / "bin" / self.name))
        return found

    def missing(self) -> str | None:
        """What to install, or None where it is there."""
        return None if self.path() else f"no {self.name}: {self.install}"

    def describe(self) -> str:
        """Name and version: the first line with a digit of what it prints about itself."""
        path = self.path()
        if path is None or not self.version:
            return self.name
        done = subprocess.run([path, self.version], capture_output=True, text=True, timeout=_PATIENCE)
        lines = [line.strip() for line in (done.stdout + done.stderr).splitlines()]
        told = next((line for line in lines if any(c.isdigit() for c in line)), "")
        return told if self.name in told else f"{self.name} {told}".strip()


_SYSTEM = "make system, or your package manager"
GLSLANG = Compiler("glslangValidator", f"Debian's glslang-tools ({_SYSTEM})")
SPIRV_VAL = Compiler("spirv-val", f"Debian's spirv-tools ({_SYSTEM})")
CC = Compiler("cc", f"a C compiler ({_SYSTEM}), or set CC", variable="CC")
CXX = Compiler("c++", f"a C++ compiler ({_SYSTEM}), or set CXX", variable="CXX")
SLANGC = Compiler("slangc", "make slang (pip install --no-deps slangtorch)", "-version", package="slangtorch")
TINT = Compiler("tint", "the WGSL compiler of Chrome, built from Dawn", "")
COMPILERS: Mapping[str, Compiler] = MappingProxyType(
    {c.name: c for c in (GLSLANG, SPIRV_VAL, CC, CXX, SLANGC, TINT)}
)


@dataclass(frozen=True)
class Step:
    """One call of a compiler.

    Attributes:
        compiler: which.
        arguments: with {source}, {target} and {include} (of headers in place of a target's own).
        source: name that the file which is read must have (compilers go by its ending).
        target: name of the file that is written, or "" for a step that only judges.
        quiet: whether anything printed is a fault: warnings then count as errors.
    """

    compiler: Compiler
    arguments: tuple[str, ...]
    source: str
    target: str = ""
    quiet: bool = False

    def run(self, text: bytes, folder: Path) -> bytes:
        """What the step makes of a file's content; the content itself where it only judges.

        Raises `EcfitError` with the compiler's own words where it fails.
        """
        source, target = folder / self.source, folder / (self.target or "none")
        source.write_bytes(text)
        include = Path(__file__).with_name("entries") / "include"
        named = {"source": source, "target": target, "include": include}
        command = [self.compiler.path() or self.compiler.name, *(a.format(**named) for a in self.arguments)]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=_PATIENCE
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise EcfitError(f"{self.compiler.name}: {error}") from None
        said = (done.stdout + done.stderr).replace(f"{folder}/", "").strip()
        if done.returncode or (self.quiet and said):
            told = " / ".join(said.splitlines()[:4]) or f"exit code {done.returncode}"
            raise EcfitError(f"{self.compiler.name} refuses the exported code: {told}")
        return target.read_bytes() if self.target else text
