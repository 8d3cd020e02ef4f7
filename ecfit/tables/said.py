"""What a written table says of itself: one line of JSON, so that it is read back without being told again."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.coordinates import Axis
from ecfit.errors import EcfitError

MARK = "ecfit-table:"
ATTRIBUTE = "ecfitTable"
# The line stands in the head of a file; nodes of a thousand entries an axis fit.
_HEAD = 1 << 18


def axis_to_dict(axis: Axis) -> dict[str, Any]:
    """An axis as JSON: by its spacing where that gives it exactly, else by its nodes."""
    head: dict[str, Any] = {"name": axis.name, "count": len(axis), "low": axis.low, "high": axis.high}
    if axis.spacing not in ("given", "clamped"):
        made = Axis.spaced(axis.name, len(axis), axis.low, axis.high, axis.spacing, axis.through)
        if made.fingerprint == axis.fingerprint:
            return {**head, "spacing": axis.spacing, "through": axis.through}
    nodes = {"nodes": axis.nodes.tolist(), "spacing": axis.spacing}
    return {**head, **nodes, **({"nominal": axis.nominal.tolist()} if axis.clamped else {})}


def axis_from_dict(data: Mapping[str, Any]) -> Axis:
    """The inverse of `axis_to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
    name, low, high = str(data["name"]), float(data["low"]), float(data["high"])
    if "nodes" not in data:
        spacing, through = str(data["spacing"]), str(data["through"])
        return Axis.spaced(name, int(data["count"]), low, high, spacing, through)
    nodes = np.asarray(data["nodes"], dtype=np.float64)
    nominal = np.asarray(data.get("nominal", nodes), dtype=np.float64)
    return Axis(name, nodes, nominal, str(data["spacing"]), low=low, high=high)


def line(said: Mapping[str, Any]) -> str:
    """The line; it ends no comment of C."""
    return f"{MARK} {json.dumps(said, allow_nan=False)}".replace("*/", "*\\/")


def read_said(path: Path) -> dict[str, Any] | None:
    """What a file says of itself, or None. Raises `EcfitError` where that is damaged."""
    if path.suffix.lower() == ".exr":
        text = _attribute(path)
    else:
        try:
            with path.open("rb") as file:
                head = file.read(_HEAD).decode("utf-8", errors="replace")
        except OSError as error:
            raise EcfitError(f"cannot read '{path}': {error.strerror or error}") from None
        text = next((row.partition(MARK)[2] for row in head.splitlines() if MARK in row), None)
    if text is None:
        return None
    try:
        said = json.JSONDecoder().raw_decode(text.strip())[0]
    except (ValueError, RecursionError):
        said = None
    if not isinstance(said, dict):
        raise EcfitError(f"'{path}': what it says of itself after '{MARK}' is damaged")
    return said


def _attribute(path: Path) -> str | None:
    import OpenEXR

    try:
        with OpenEXR.File(str(path), separate_channels=True, header_only=True) as file:
            found = file.header().get(ATTRIBUTE)
    except Exception:  # whatever its C++ raises; the reader of the pixels tells it better
        return None
    return found if isinstance(found, str) else None
