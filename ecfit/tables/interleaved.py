"""Channels that follow each other entry by entry, as in an RG texture."""

import numpy as np

from ecfit.errors import EcfitError

CHANNELS = {"R": 0, "G": 1, "B": 2, "A": 3}


def picked(flat: np.ndarray, count: int, channel: str | None, what: str) -> np.ndarray:
    """Every k-th of k `count` numbers, from the one that `channel` names (0, 1, ... or R, G, B, A).

    Raises `EcfitError` where there are not that many, and where one of several channels has to be named.
    """
    several = flat.size // count if count else 0
    if several == 0 or flat.size != several * count or several > len(CHANNELS):
        raise EcfitError(f"{what} holds {flat.size} numbers, the axes need {count}: check their counts")
    if several == 1 and channel is None:
        return flat
    index = int(channel) if channel is not None and channel.isdecimal() else CHANNELS.get(channel or "", -1)
    if not 0 <= index < several:
        raise EcfitError(f"{what} has {several} numbers an entry: which channel? Expected 0 to {several - 1}")
    return flat[index::several]
