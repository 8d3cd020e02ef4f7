"""Exported C and C++, compiled by the system's compiler and called from Python: does it do what it says?"""

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ecfit.errors import EcfitError

# Everything that a renderer's build might turn on; contraction off, so that each operation rounds as written.
FLAGS = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Wshadow", "-Werror", "-O2", "-ffp-contract=off")
STANDARDS = {"c99": "cc", "c11": "cc", "c++17": "c++"}


def compiler(standard: str) -> str | None:
    """The path of the system's compiler for a language standard; None where there is none."""
    return shutil.which(STANDARDS[standard])


def compiled(
    sources: Sequence[str], names: Sequence[tuple[str, int]], standard: str = "c99"
) -> list[Callable[..., np.ndarray]]:
    """Functions of float32 arrays of one shape, from exported source text.

    Args:
        sources: exported files, in C or C++, by standard.
        names: (function, number of its arguments).
        standard: "c99", "c11" or "c++17".

    Raises `EcfitError` where there is no compiler, and with its first words where it has a warning.
    """
    found = compiler(standard)
    if found is None:
        raise EcfitError(f"no {STANDARDS[standard]} here: install a C compiler")
    suffix = "cpp" if standard.startswith("c++") else "c"
    loops = [_loop(name, count, suffix) for name, count in names]
    with TemporaryDirectory() as folder:
        path, library = Path(folder) / f"exported.{suffix}", Path(folder) / "exported.so"
        path.write_text("\n".join([*sources, *loops]), encoding="utf-8")
        command = [found, f"-std={standard}", *FLAGS, "-shared", "-fPIC", "-o", library, path, "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise EcfitError(f"{found} refuses the exported code: {done.stderr.strip()[:2000]}")
        loaded = ctypes.CDLL(str(library))
    return [_called(getattr(loaded, f"{name}_loop"), count) for name, count in names]


def _loop(name: str, count: int, suffix: str) -> str:
    external = 'extern "C" ' if suffix == "cpp" else ""
    parameters = "int n, const float *const *in, float *out"
    given = ", ".join(f"in[{i}][k]" for i in range(count))
    head = f"{external}void {name}_loop({parameters})"
    return f"{head};\n{head} {{ for (int k = 0; k < n; ++k) out[k] = {name}({given}); }}\n"


def _called(loop: Callable[..., None], count: int) -> Callable[..., np.ndarray]:
    pointer = ctypes.POINTER(ctypes.c_float)

    def function(*points: np.ndarray) -> np.ndarray:
        arrays = [np.ascontiguousarray(p, dtype=np.float32) for p in points]
        if len(arrays) != count or len({a.shape for a in arrays}) > 1:
            raise EcfitError(f"expected {count} arrays of one shape")
        out = np.empty(arrays[0].shape, dtype=np.float32)
        inputs = (pointer * count)(*(a.ctypes.data_as(pointer) for a in arrays))
        loop(ctypes.c_int(out.size), inputs, out.ctypes.data_as(pointer))
        return out

    return function
