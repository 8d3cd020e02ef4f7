"""How far an approximation is from a table: the same metrics for our fits, published ones and tables."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Protocol

import numpy as np

from ecfit.approximation import Approximation
from ecfit.contract import Contract
from ecfit.coordinates import Grid
from ecfit.errors import EcfitError
from ecfit.tables import Table


@dataclass(frozen=True)
class Errors:
    """Errors over the finite entries of a table, absolute, unweighted.

    Attributes:
        mae, rmse, max_error: mean absolute, root mean square and largest error.
        place: coordinates of the largest error, name -> value, as a fit sees them.
        furnace_mean, furnace_max: mean and largest |E_true / E_approx - 1|: the deviation of a white
            furnace when the approximation normalises a BSDF (largest: infinite where E_approx <= 0).
    """

    mae: float
    rmse: float
    max_error: float
    place: Mapping[str, float]
    furnace_mean: float
    furnace_max: float

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Errors":
        """The inverse of `to_dict`; null means infinite."""
        try:
            values = {f.name: data[f.name] for f in fields(cls)}
            place = {str(k): float(v) for k, v in values.pop("place").items()}
            numbers = {k: float("inf") if v is None else float(v) for k, v in values.items()}
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            raise EcfitError(f"malformed errors ({type(error).__name__}: {error})") from None
        return cls(place=place, **numbers)


class Gridded(Protocol):
    """A grid with its conventions: a table, or the request for one."""

    @property
    def grid(self) -> Grid: ...
    @property
    def contract(self) -> Contract: ...


def predict(approximation: Approximation, table: Gridded) -> np.ndarray:
    """The approximation on the table's nodes, at the coordinates that a fit sees; the table's shape.

    What the table holds fixed by its contract (ior = 1.5) a formula may have as a variable. Raises
    `EcfitError` where the table does not have the approximation's coordinates.
    """
    axes = {axis.name: axis.nominal for axis in table.grid.axes}
    nodes, order = approximation.nodes_of(axes, table.contract.parameters)
    return np.transpose(approximation.on_grid(nodes), np.argsort(order)).reshape(table.grid.shape)


def signed_error(approximation: Approximation, table: Table) -> np.ndarray:
    """Approximation minus table, the table's shape."""
    return predict(approximation, table) - table.values


def measure(approximation: Approximation, table: Table) -> Errors:
    """Errors of an approximation on a table."""
    predicted = predict(approximation, table)
    usable = table.usable
    if not usable.any():
        raise EcfitError("the table has no finite entry to measure against")
    error = np.where(usable, np.abs(predicted - table.values), -1.0)
    index = np.unravel_index(int(np.argmax(error)), error.shape)
    finite = error[usable]
    with np.errstate(divide="ignore", invalid="ignore"):
        furnace = np.abs(table.values[usable] / predicted[usable] - 1.0)
    furnace = np.where((predicted[usable] > 0.0) & np.isfinite(furnace), furnace, np.inf)
    return Errors(
        mae=float(finite.mean()),
        rmse=float(np.sqrt(np.mean(finite**2))),
        max_error=float(finite.max()),
        place={a.name: float(a.nominal[i]) for a, i in zip(table.axes, index, strict=True)},
        furnace_mean=float(furnace.mean()),
        furnace_max=float(furnace.max()),
    )


def prediction_range(approximation: Approximation, table: Gridded) -> tuple[float, float]:
    """Least and largest value of the approximation on the table's nodes and on a grid between them."""
    counts = {1: 4097, 2: 193, 3: 49}
    count = counts.get(len(approximation.domain), 13)
    grid = [low + (high - low) * np.linspace(0.0, 1.0, count) for low, high in approximation.domain]
    between = approximation.on_grid(grid)
    nodes = predict(approximation, table)
    return float(min(between.min(), nodes.min())), float(max(between.max(), nodes.max()))
