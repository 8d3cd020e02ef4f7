"""A table as an OpenEXR image: rows of pixels, slices below each other or as parts."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import IO, Any

import numpy as np

from ecfit.errors import EcfitError


def write_exr(
    file: IO[bytes],
    entries: np.ndarray,
    channels: Sequence[str],
    attributes: Mapping[str, str],
    parts: bool,
) -> None:
    """Write pixels of shape (..., height, width, channels), float32 or float16.

    Slices (the dimensions before height) stand below each other, or each in a part of its own. Raises
    `EcfitError` for other types of numbers, which OpenEXR lacks, and OSError where the file does not hold all
    pixels in the end: OpenEXR itself often says nothing of a full disk.
    """
    import OpenEXR

    if entries.dtype not in (np.float32, np.float16):
        raise EcfitError(
            f"OpenEXR has no {entries.dtype}: use number = float32 or float16, or another format"
        )
    # A file of one dimension is an image of one row.
    pixels = entries if entries.ndim > 2 else entries[None]
    slices = pixels.reshape(-1, *pixels.shape[-3:])
    if not parts:
        slices = slices.reshape(1, -1, *slices.shape[2:])

    def part(i: int, planes: Mapping[str, np.ndarray]) -> Any:
        header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION, **attributes}
        return OpenEXR.Part(header, dict(planes), f"slice{i}")

    planes = [{n: np.ascontiguousarray(s[..., k]) for k, n in enumerate(channels)} for s in slices]
    with suppress(RuntimeError):  # of some failures it tells, of others not: what is in the file counts
        # OpenEXR writes by name only; the caller renames.
        OpenEXR.File([part(i, image) for i, image in enumerate(planes)]).write(file.name)
    if not _holds(file.name, planes):
        raise OSError("what was written does not read back: is the disk full?")


def _holds(name: str, planes: Sequence[Mapping[str, np.ndarray]]) -> bool:
    """Whether a file holds these pixels by channel, part by part."""
    import OpenEXR

    with suppress(Exception), OpenEXR.File(name, separate_channels=True) as found:  # whatever its C++ raises
        there = [{n: c.pixels for n, c in part.channels.items()} for part in found.parts]
        return len(there) == len(planes) and all(
            has.keys() == wanted.keys() and all(np.array_equal(has[n], wanted[n]) for n in wanted)
            for has, wanted in zip(there, planes, strict=True)
        )
    return False
