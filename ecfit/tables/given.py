"""Somebody else's numbers: what they must be before they are a table, and what looks odd in them."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ecfit.contract import Contract
from ecfit.coordinates import SPACINGS, VIEWS, Axis
from ecfit.errors import EcfitError, unknown

STORED = ("E", "1-E")
# Coordinates whose range needs no saying.
_UNIT = ("mu", "r", "alpha", "F0")
# Beyond the rounding of 8-bit and half-precision tables.
_ABOVE_ONE = 1.01


def numbers(values: Any, label: str) -> np.ndarray:
    """A float64 copy; raises `EcfitError` unless `values` is a full array of real numbers."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise EcfitError(f"{label} must be an array of numbers whose rows have one length") from None
    if np.ma.is_masked(values):
        raise EcfitError(f"{label} are masked in places: a table has a number everywhere")
    if array.dtype.kind not in "iuf":
        raise EcfitError(f"{label} must be real numbers, got an array of {array.dtype}")
    return np.array(array, dtype=np.float64)


def full_range(name: str, low: float | None = None, high: float | None = None) -> tuple[float, float]:
    """[0, 1] for mu, r, alpha and F0, or the ends that are given; raises `EcfitError` for other names."""
    if name not in _UNIT and (low is None or high is None):
        raise EcfitError(f"axis '{name}' has no range that goes without saying: give low and high")
    return 0.0 if low is None else low, 1.0 if high is None else high


def given_axes(axes: Any, shape: Sequence[int] | None = None) -> tuple[Axis, ...]:
    """The axes of a table from a mapping name -> `Axis`, nodes, count, or the name of a spacing.

    A count means equally spaced nodes, both ends included, over [0, 1]; a spacing's name takes its count
    from `shape`. Raises `EcfitError` for anything else, and for coordinates that cannot be.
    """
    if not isinstance(axes, Mapping) or not axes:
        raise EcfitError("axes must be a mapping such as {'r': 64, 'mu': 'texel-centre'}")
    if shape is not None and len(shape) != len(axes):
        raise EcfitError(
            f"the values have {len(shape)} dimensions of shape {tuple(shape)}, but there are {len(axes)} "
            f"axes ({', '.join(map(str, axes))}): one dimension an axis, in that order"
        )
    made = []
    for i, (name, what) in enumerate(axes.items()):
        if isinstance(what, Axis):
            if what.name != name:
                raise EcfitError(f"axis '{what.name}' given under the name '{name}'")
            made.append(what)
        elif isinstance(what, str):
            if what not in SPACINGS:
                raise unknown("spacing", what, SPACINGS)
            if shape is None:
                raise EcfitError(
                    f"axis '{name}': how many nodes? Give ecfit.Axis.spaced('{name}', n, spacing='{what}')"
                )
            made.append(Axis.spaced(name, shape[i], *full_range(name), spacing=what))
        elif isinstance(what, int | np.integer) and not isinstance(what, bool):
            made.append(Axis.spaced(name, int(what), *full_range(name)))
        else:
            made.append(Axis.given(name, what))  # type: ignore[arg-type]
    _check_coordinates(made)
    found = tuple(len(a) for a in made)
    if shape is not None and tuple(shape) != found:
        wanted = ", ".join(f"{a.name} = {len(a)}" for a in made)
        swapped = " (transpose them?)" if sorted(shape) == sorted(found) else ""
        raise EcfitError(f"the values have shape {tuple(shape)}, the axes say {wanted}{swapped}")
    return tuple(made)


def _check_coordinates(axes: Sequence[Axis]) -> None:
    seen: dict[str, str] = {}
    for axis in axes:
        view = VIEWS.get(axis.name)
        parameter = axis.name if view is None else view.of
        if parameter in seen:
            raise EcfitError(f"axes '{seen[parameter]}' and '{axis.name}' are the same coordinate")
        seen[parameter] = axis.name
        low, high = (view.map.low, view.map.high) if view else (0.0, 1.0 if axis.name == "mu" else np.inf)
        known = view is not None or axis.name in ("mu", *(v.of for v in VIEWS.values()))
        if known and not (low <= axis.nodes[0] and axis.nodes[-1] <= high):
            raise EcfitError(
                f"axis '{axis.name}' spans [{axis.nodes[0]:g}, {axis.nodes[-1]:g}], "
                f"outside [{low:g}, {high:g}]"
            )


def as_albedo(array: np.ndarray, stored: str, scale: float) -> np.ndarray:
    """E from the numbers of a file: `stored` is "E" or "1-E", and the number `scale` stands for 1."""
    if not isinstance(stored, str) or stored not in STORED:
        raise unknown("stored value", stored, STORED)
    number = isinstance(scale, int | float) and not isinstance(scale, bool)
    if not (number and 0.0 < scale < float("inf")):
        raise EcfitError(f"scale is the stored number that stands for 1, such as 65535, got {scale!r}")
    array = array / float(scale)
    return 1.0 - array if stored == "1-E" else array


def claimed(contract: Any, stored: str | None, axes: Sequence[Axis]) -> tuple[Contract, str]:
    """The contract of the table, and what its source stores ("E" where nobody says)."""
    if isinstance(contract, Mapping):
        said = contract.get("stored", "E")
        if stored is not None and "stored" in contract and said != stored:
            raise EcfitError(f"stored = '{stored}', but the contract says '{said}': leave one of them out")
        stored = said if stored is None else stored
        contract = Contract.from_dict({"model": "unknown", **contract, "stored": "E"})
    if not isinstance(contract, Contract):
        raise EcfitError(
            f"a contract is an ecfit.Contract or a mapping such as {{'model': 'unknown'}}, got {contract!r}"
        )
    sampling = "clamped" if any(a.clamped for a in axes) else "true"
    return replace(contract, sampling=sampling), "E" if stored is None else stored


def error_estimates(errors: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Absolute errors of `shape` from an array or one number for all; NaN, which is unknown, from None."""
    if errors is None:
        return np.full(shape, np.nan)
    array = numbers(errors, "errors")
    if array.shape not in ((), shape):
        raise EcfitError(f"errors have shape {array.shape}, the values {shape}")
    if not np.all(array >= 0.0):
        raise EcfitError("errors must be 0 or more; leave them out where they are not known")
    return np.broadcast_to(array, shape).copy()


def content_key(
    contract: Contract, tolerance: float, axes: Sequence[Axis], arrays: Sequence[np.ndarray]
) -> str:
    """Hash of everything that a given table says: equal keys mean equal tables."""
    head = ["given", contract.to_dict(), repr(float(tolerance))]
    digest = hashlib.sha256(json.dumps(head, sort_keys=True).encode())
    for axis in axes:
        digest.update(axis.fingerprint)
    for array in arrays:
        digest.update(array.tobytes())
    return digest.hexdigest()[:16]


def remarks(values: np.ndarray, axes: Sequence[Axis], contract: Contract) -> list[str]:
    """What looks like another convention than the contract's. Nothing is guessed: people are told."""
    if not contract.quantity.endswith("-albedo"):
        return []
    low, high = float(values.min()), float(values.max())
    if contract.transport == "energy" and high > _ABOVE_ONE:
        return [
            f"values reach {high:.6g}, but an albedo in energy transport is at most 1: are they per cent or "
            "whole numbers (then give scale), or in radiance transport?"
        ]
    if low < 1.0 - _ABOVE_ONE:
        return [f"values fall to {low:.6g}, but an albedo is not negative: are scale and stored right?"]
    rough = next((i for i, a in enumerate(axes) if a.name in ("r", "alpha")), None)
    if rough is None:
        return []
    # Of E, smooth surfaces seen from above have the most; 1 - E rises with roughness from nearly 0.
    index = tuple(-1 if a.name == "mu" else slice(None) for a in axes)
    left = sum(a.name != "mu" for a in axes[:rough])
    along = np.moveaxis(values[index], left, -1)
    along = along.reshape(-1, len(axes[rough])).mean(axis=0)
    if along[0] < 0.1 and along[-1] > along[0] + 0.1:
        return [
            f"seen from above, values rise with roughness from {along[0]:.3g} to {along[-1]:.3g}, as 1 - E "
            "does, or E whose axes are swapped: say stored = '1-E', or check order"
        ]
    return []
