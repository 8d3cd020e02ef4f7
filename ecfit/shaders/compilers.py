"""Steps of compilers as data: what is called with which arguments, and what is made of which file."""

import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ecfit.errors import EcfitError
from ecfit.export.compilers import CC, CXX, PATIENCE, SYSTEM, Compiler

GLSLANG = Compiler("glslangValidator", f"Debian's glslang-tools ({SYSTEM})")
SPIRV_VAL = Compiler("spirv-val", f"Debian's spirv-tools ({SYSTEM})")
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
        start = self.compiler.command() or [self.compiler.name]
        command = [*start, *(a.format(**named) for a in self.arguments)]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=PATIENCE
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise EcfitError(f"{self.compiler.name}: {error}") from None
        said = (done.stdout + done.stderr).replace(f"{folder}/", "").strip()
        if done.returncode or (self.quiet and said):
            told = " / ".join(said.splitlines()[:4]) or f"exit code {done.returncode}"
            raise EcfitError(f"{self.compiler.name} refuses the exported code: {told}")
        return target.read_bytes() if self.target else text
