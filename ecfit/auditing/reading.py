"""A reading: numbers, where they are said to stand, and what they are said to be."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ecfit.contract import Contract
from ecfit.coordinates import Axis, Grid


@dataclass(frozen=True, eq=False)
class Reading:
    """One way to understand a table, or a formula sampled on a grid.

    Attributes:
        axes: where the values stand: their `nodes` are true coordinates.
        values: one dimension an axis; NaN where nothing is known.
        contract: what the values are.
        formula: whether they were computed by a formula: then nothing can be wrong with a file's order of
            numbers or with texels, but the arguments may be meant otherwise.
    """

    axes: tuple[Axis, ...]
    values: np.ndarray
    contract: Contract
    formula: bool = False

    @property
    def grid(self) -> Grid:
        return Grid(self.axes)

    def axis(self, name: str) -> Axis | None:
        """The axis of that name, or None."""
        return next((a for a in self.axes if a.name == name), None)

    def with_axis(self, old: Axis, new: Axis) -> "Reading":
        """The same with another axis in the place of `old`."""
        return replace(self, axes=tuple(new if a is old else a for a in self.axes))

    def points(self, entries: np.ndarray) -> dict[str, np.ndarray]:
        """True coordinates of the entries with flat indices `entries`."""
        return self.grid.nodes_at(entries)

    def place(self, entry: int) -> Mapping[str, float]:
        """Coordinates of one entry, as the file's reader sees them."""
        return {name: float(x[0]) for name, x in self.grid.nominal_at(np.array([entry])).items()}
