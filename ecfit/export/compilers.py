"""The compilers of the system, as data: what is called, how it tells its version, what to install."""

import importlib.util
import os
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

# Seconds after which a compiler is taken to hang; the slowest here (slangc to a library) needs 20.
PATIENCE = 300.0


@dataclass(frozen=True)
class Compiler:
    """A program that reads one file and writes another.

    Attributes:
        name: the executable.
        install: what to do where it is missing.
        version: the argument that makes it print its version, or "" where there is none.
        variable: name of an environment variable that, if set, is the command instead, as make reads it:
            "clang", "ccache gcc", "gcc -m32"; or "".
        package: a Python package that has it in its folder `bin`, or "".
    """

    name: str
    install: str
    version: str = "--version"
    variable: str = ""
    package: str = ""

    def command(self) -> list[str] | None:
        """Its path and the arguments that it is always called with, or None where it is not there."""
        name, *arguments = _words(os.environ.get(self.variable, "")) or [self.name]
        found = shutil.which(name)
        if found is None and self.package:
            spec = importlib.util.find_spec(self.package)
            if spec is not None and spec.origin is not None:
                found = shutil.which(str(Path(spec.origin).parent / "bin" / self.name))
        return None if found is None else [found, *arguments]

    def missing(self) -> str | None:
        """What to install, or None where it is there."""
        return None if self.command() else f"no {self.name}: {self.install}"

    def describe(self) -> str:
        """Name and version: the first line with a digit of what it prints about itself."""
        command = self.command()
        if command is None or not self.version:
            return self.name
        done = subprocess.run([*command, self.version], capture_output=True, text=True, timeout=PATIENCE)
        lines = [line.strip() for line in (done.stdout + done.stderr).splitlines()]
        told = next((line for line in lines if any(c.isdigit() for c in line)), "")
        return told if self.name in told else f"{self.name} {told}".strip()


def _words(text: str) -> list[str]:
    """A command as a shell reads it; a quote that is never closed is part of its word."""
    try:
        return shlex.split(text)
    except ValueError:
        return [text]


SYSTEM = "make system, or your package manager"
CC = Compiler("cc", f"a C compiler ({SYSTEM}), or set CC", variable="CC")
CXX = Compiler("c++", f"a C++ compiler ({SYSTEM}), or set CXX", variable="CXX")

# A library that Python loads. All that a renderer's build might warn of is an error; no contraction of
# a * b + c, which would be more exact than the languages promise.
LIBRARY = (
    "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wpedantic", "-Wshadow", "-Werror", "-O2",
    "-ffp-contract=off", "-shared", "-fPIC",
)  # fmt: skip
