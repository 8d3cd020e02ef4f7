"""Weights of a table's entries, beside those of its axes."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ecfit.coordinates import viewed
from ecfit.errors import EcfitError
from ecfit.tables import Table


def axis_of(coordinate: str, axes: Sequence[str]) -> str:
    """The axis that a coordinate in any view stands for. Raises `EcfitError` where there is none."""
    for name in axes:
        if viewed(coordinate, name, 0.5) is not None:
            return name
    raise EcfitError(f"the table has no coordinate '{coordinate}': its axes are {', '.join(axes)}")


def check_powers(given: Mapping[str, Any], axes: Sequence[str]) -> None:
    """Raise `EcfitError` unless `given` maps coordinates of a table to powers."""
    for coordinate, power in given.items():
        axis_of(coordinate, axes)
        if isinstance(power, bool) or not isinstance(power, int | float) or not np.isfinite(power):
            raise EcfitError(f"weights: {coordinate} needs a power, a finite number, got {power!r}")


def entry_weights(table: Table, given: Any, count: int) -> np.ndarray | None:
    """Weights of all entries, flat, of mean 1; None where none are given.

    Args:
        count: of the coefficients that the weighted entries have to determine.
        given: an array of the table's shape, or coordinate -> power: the weight is the product of
            coordinate^power, at the coordinates that a fit sees.

    Raises `EcfitError` for anything else, for weights that are negative, not finite or all 0, and for fewer
    positive ones than coefficients.
    """
    if given is None:
        return None
    if isinstance(given, Mapping):
        check_powers(given, table.names)
        weights = np.ones(table.values.shape)
        mesh = dict(
            zip(table.names, np.meshgrid(*(a.nominal for a in table.axes), indexing="ij"), strict=True)
        )
        for coordinate, power in given.items():
            name = axis_of(coordinate, table.names)
            values = np.asarray(viewed(coordinate, name, mesh[name]))
            with np.errstate(divide="ignore", invalid="ignore"):
                weights = weights * values ** float(power)
    else:
        try:
            weights = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            raise EcfitError("weights are an array of the table's shape, or coordinate -> power") from None
        if weights.shape != table.values.shape:
            raise EcfitError(f"weights have the shape {weights.shape}, the table {table.values.shape}")
    if not np.all(np.isfinite(weights)) or np.any(weights < 0.0) or not np.any(weights > 0.0):
        raise EcfitError(
            "weights must be finite, not negative and not all 0: a negative power needs an axis without 0"
        )
    positive = np.count_nonzero(weights)
    if positive < count:
        raise EcfitError(
            f"the form has {count} coefficients, but only {positive} of {weights.size} entries have a weight "
            "above 0: choose fewer terms or weigh more entries"
        )
    return weights.ravel() / weights.mean()
