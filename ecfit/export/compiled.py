"""Exported C and C++, compiled by the system's compiler and called from Python: does it do what it says?"""

import ctypes
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ecfit.errors import EcfitError
from ecfit.export.compilers import CC, CXX, LIBRARY

STANDARDS = {"c99": CC, "c11": CC, "c++17": CXX}


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
    compiler = STANDARDS[standard]
    start = compiler.command()
    if start is None:
        raise EcfitError(str(compiler.missing()))
    suffix = "cpp" if standard.startswith("c++") else "c"
    loops = [_loop(name, count, suffix) for name, count in names]
    with TemporaryDirectory() as folder:
        path, library = Path(folder) / f"exported.{suffix}", Path(folder) / "exported.so"
        path.write_text("\n".join([*sources, *loops]), encoding="utf-8")
        command = [*start, f"-std={standard}", *LIBRARY, "-o", library, path, "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise EcfitError(f"{compiler.name} refuses the exported code: {done.stderr.strip()[:2000]}")
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
