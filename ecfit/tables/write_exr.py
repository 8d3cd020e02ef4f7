"""A table as an OpenEXR image: rows of pixels, slices below each other or as parts."""

from collections.abc import Mapping, Sequence
from pathlib import Path
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
    `EcfitError` for other types of numbers, which OpenEXR lacks.
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

    def part(i: int, image: np.ndarray) -> Any:
        header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION, **attributes}
        planes = {n: np.ascontiguousarray(image[..., k]) for k, n in enumerate(channels)}
        return OpenEXR.Part(header, planes, f"slice{i}")

    # OpenEXR writes by name only; the caller renames.
    OpenEXR.File([part(i, image) for i, image in enumerate(slices)]).write(str(Path(file.name)))
