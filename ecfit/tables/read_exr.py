"""Numbers from an OpenEXR image: one channel of its parts."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.errors import EcfitError


def read_exr(path: Path, count: int, channel: str | None) -> np.ndarray:
    """One channel, shape (height, width), or (parts, height, width) where several parts have it.

    `channel` may be left out where there is only one, or one is called R or Y. Only the header is read until
    the sizes are known to come to `count` numbers. Raises `EcfitError` for anything else.
    """
    headers = _parts(path, header_only=True)
    chosen = _channel(path, set().union(*(part.names for part in headers)), channel)
    having = [i for i, part in enumerate(headers) if chosen in part.names]
    sizes = [headers[i].size for i in having]
    if len(set(sizes)) > 1 or sum(h * w for h, w in sizes) != count:
        shown = ", ".join(f"{h} x {w}" for h, w in sizes[:4]) + (", ..." if len(sizes) > 4 else "")
        raise EcfitError(
            f"'{path}' has {shown} pixels (height x width) of channel {chosen}, the axes need {count} in "
            "all: check the counts of the axes"
        )
    parts = _parts(path)
    planes = [parts[i].pixels.get(chosen) for i in having if i < len(parts)]
    if len(planes) != len(having) or any(
        not isinstance(p, np.ndarray) or p.dtype.kind not in "iuf" or p.shape != s
        for p, s in zip(planes, sizes, strict=True)
    ):
        raise EcfitError(f"'{path}' is damaged, deep or subsampled: channel {chosen} could not be read whole")
    array = np.array(planes, dtype=np.float64)
    return array[0] if len(having) == 1 else array


@dataclass(frozen=True)
class _Part:
    """Names of the channels, (height, width), and pixels by channel (none where only headers were read)."""

    names: set[str]
    size: tuple[int, int]
    pixels: dict[str, Any]


def _parts(path: Path, header_only: bool = False) -> list[_Part]:
    import OpenEXR

    def part(found: Any) -> _Part:
        # Python's integers: the window of a hostile header would overflow NumPy's.
        (x0, y0), (x1, y1) = ([int(v) for v in corner] for corner in found.header["dataWindow"])
        names = {c.name for c in found.header["channels"]}
        return _Part(names, (y1 - y0 + 1, x1 - x0 + 1), {n: c.pixels for n, c in found.channels.items()})

    try:
        with OpenEXR.File(str(path), separate_channels=True, header_only=header_only) as file:
            parts = [part(p) for p in file.parts]  # leaving the file empties its headers
    except Exception:  # whatever its C++ raises: RuntimeError, ValueError, UnicodeDecodeError, ...
        parts = []
    if not parts:
        raise EcfitError(f"cannot read '{path}': it is damaged or no OpenEXR image")
    return parts


def _channel(path: Path, names: set[str], channel: str | None) -> str:
    """The channel that is meant."""
    usual = [n for n in ("R", "Y") if n in names]
    if channel is None:
        if len(names) == 1:
            return next(iter(names))
        if usual:
            return usual[0]
    elif channel in names:
        return channel
    missing = "which channel?" if channel is None else f"it has no channel '{channel}':"
    raise EcfitError(f"'{path}': {missing} expected one of {', '.join(sorted(names)) or '(none)'}")
