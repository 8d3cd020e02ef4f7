"""Numbers from a file of nothing but numbers, little-endian."""

from pathlib import Path

import numpy as np

from ecfit.errors import EcfitError
from ecfit.tables.interleaved import picked
from ecfit.tables.numbers import number


def read_raw(path: Path, count: int, channel: str | None, kind: str | None) -> np.ndarray:
    """`count` numbers of the type `kind`, one dimension; of interleaved channels the one that is named.

    Raises `EcfitError` for a file of another size, and where `kind` is not said.
    """
    if kind is None:
        raise EcfitError(
            f"'{path}' does not say what its numbers are: give number, such as uint16 or float16"
        )
    dtype = np.dtype(number(kind).dtype)
    size = path.stat().st_size
    # Four channels at most: what is larger is not read.
    if size % dtype.itemsize or size // dtype.itemsize > 4 * count:
        raise EcfitError(
            f"'{path}' has {size} bytes, the axes need {count} numbers of {dtype.itemsize} bytes: check "
            "number and the counts of the axes"
        )
    return picked(np.fromfile(path, dtype), count, channel, f"'{path}'")
