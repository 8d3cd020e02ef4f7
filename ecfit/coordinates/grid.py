"""A grid: the tensor product of axes, in the order given (the last axis varies fastest)."""

from dataclasses import dataclass

import numpy as np

from ecfit.coordinates.axis import Axis
from ecfit.errors import EcfitError


@dataclass(frozen=True)
class Grid:
    """The tensor product of n axes.

    Raises `EcfitError` for no axes, and for two of one name.
    """

    axes: tuple[Axis, ...]

    def __post_init__(self) -> None:
        if not self.axes:
            raise EcfitError("a grid needs at least one axis")
        names = [a.name for a in self.axes]
        if len(set(names)) < len(names):
            raise EcfitError(f"axis names repeat: {', '.join(names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the axes, in order."""
        return tuple(a.name for a in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of nodes of each axis."""
        return tuple(len(a) for a in self.axes)

    @property
    def size(self) -> int:
        """Number of entries."""
        return int(np.prod(self.shape))

    @property
    def domain(self) -> tuple[tuple[float, float], ...]:
        """Range of each axis in the coordinates that a fit sees."""
        return tuple((a.low, a.high) for a in self.axes)

    def nodes_at(self, flat: np.ndarray) -> dict[str, np.ndarray]:
        """True coordinates of the entries with flat (C-order) indices `flat`, one array a name."""
        index = np.unravel_index(flat, self.shape)
        return {a.name: a.nodes[i] for a, i in zip(self.axes, index, strict=True)}

    def nominal_at(self, flat: np.ndarray) -> dict[str, np.ndarray]:
        """The same in the coordinates that a fit sees."""
        index = np.unravel_index(flat, self.shape)
        return {a.name: a.nominal[i] for a, i in zip(self.axes, index, strict=True)}
