"""Calls `run(given, found)` of a shared library. A process of its own, as a library can crash too.

    python -P library.py FOLDER

FOLDER holds `program` (the library) and `given.npy` (functions, points, 4) float32; written are `found.npy`
(functions, points) float32 and `device.txt`.
"""

import ctypes
import platform
import sys
from pathlib import Path

import numpy as np


def main() -> None:
    folder = Path(sys.argv[1])
    (folder / "device.txt").write_text(platform.machine())
    given = np.ascontiguousarray(np.load(folder / "given.npy"))
    found = np.full(given.shape[:2], np.nan, dtype=np.float32)
    pointer = ctypes.POINTER(ctypes.c_float)
    ctypes.CDLL(str(folder / "program")).run(given.ctypes.data_as(pointer), found.ctypes.data_as(pointer))
    np.save(folder / "found.npy", found)


if __name__ == "__main__":
    main()
