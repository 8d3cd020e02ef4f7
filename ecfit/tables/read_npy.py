"""Numbers from a NumPy array file. Nothing in it is executed: pickled objects are refused."""

import warnings
from pathlib import Path

import numpy as np

from ecfit.errors import EcfitError

_CHANNELS = {"R": 0, "G": 1, "B": 2, "A": 3}


def read_npy(path: Path, count: int, channel: str | None) -> np.ndarray:
    """The array of a `.npy` file, of `count` numbers; `channel` picks from its last dimension.

    The file is mapped, not read, until its size is known to be right. Raises `EcfitError` for anything else.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # the header's parser warns of odd literals before it refuses them
            array = np.lib.format.open_memmap(path, mode="r")
    except Exception as error:  # the header's parser raises a dozen kinds
        why = "it holds Python objects" if "Python objects" in str(error) else "it is damaged or no .npy file"
        raise EcfitError(
            f"cannot read '{path}': {why}; save plain numbers with numpy.save(path, array)"
        ) from None
    if array.dtype.kind not in "iuf":
        raise EcfitError(f"'{path}' holds {array.dtype}, expected real numbers")
    if channel is not None:
        last = array.shape[-1] if array.ndim else 0
        index = int(channel) if channel.isdecimal() and len(channel) < 9 else _CHANNELS.get(channel, -1)
        if not 0 <= index < last:
            raise EcfitError(
                f"'{path}' has no channel '{channel}': expected 0 to {last - 1} (or R, G, B, A), the index "
                f"in the last dimension of its shape {array.shape}"
            )
        array = array[..., index]
    if array.size != count:
        raise EcfitError(
            f"'{path}' holds {' x '.join(map(str, array.shape))} numbers, the axes need {count} in all: "
            "check the counts of the axes, or say which channel"
        )
    return np.array(array, dtype=np.float64)
