"""A table as an approximation: multilinear look-up, as renderers sample textures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.approximation.formula import Array, Box, Formula, broadcast
from ecfit.coordinates import MAPS
from ecfit.errors import EcfitError, unknown
from ecfit.expressions import Node
from ecfit.forms import Minimum


@dataclass(frozen=True, eq=False)
class Lookup(Formula):
    """Values on nodes that are uniform in t, x = map(t), ends included; linear in each t between them.

    Attributes:
        grid: values, float64, one dimension a variable.
        ranges: (low, high) of each variable.
        through: name of the map of each variable (`ecfit.coordinates.MAPS`).

    Raises `EcfitError` for fewer than 2 values an axis, values that are not finite, and unknown maps.
    """

    kind: ClassVar[str] = "lookup"

    grid: np.ndarray
    ranges: tuple[tuple[float, float], ...]
    through: tuple[str, ...]

    def __post_init__(self) -> None:
        grid = np.array(self.grid, dtype=np.float64)
        if grid.ndim != len(self.ranges) or grid.ndim != len(self.through) or min(grid.shape) < 2:
            raise EcfitError("a look-up needs at least 2 values, a range and a map for each variable")
        if not np.all(np.isfinite(grid)):
            raise EcfitError("a look-up's values must be finite")
        for name in self.through:
            if name not in MAPS:
                raise unknown("map", name, MAPS)
        grid.setflags(write=False)
        object.__setattr__(self, "grid", grid)

    @property
    def variables(self) -> int:
        return self.grid.ndim

    @property
    def coefficients(self) -> np.ndarray:
        return self.grid.ravel()

    def value(self, points: Sequence[Array]) -> Array:
        arrays = broadcast(points)
        xp = jnp if any(isinstance(p, jax.Array) for p in arrays) else np
        corners: list[tuple[Array, Array, Array]] = []
        rows = zip(arrays, self.grid.shape, self.ranges, self.through, strict=True)
        for x, count, (low, high), name in rows:
            inverse = MAPS[name].inverse
            start, end = float(inverse(low)), float(inverse(high))
            t = (inverse(xp.clip(x, low, high)) - start) / (end - start) * (count - 1)
            cell = xp.clip(xp.floor(t), 0.0, count - 2.0)
            corners.append((cell.astype(int), 1.0 - (t - cell), t - cell))
        values = xp.asarray(self.grid)
        total = xp.zeros_like(arrays[0], dtype=np.float64)
        for corner in np.ndindex(*(2,) * self.grid.ndim):
            weight, place = 1.0, []
            for bit, (index, near, far) in zip(corner, corners, strict=True):
                weight = weight * (far if bit else near)
                place.append(index + bit)
            total = total + weight * values[tuple(place)]
        return total

    def expression(self, names: Sequence[str]) -> Node:
        raise EcfitError("a table is not a formula: it has no expression")

    def smallest_denominator(self, domain: Box) -> Minimum:
        return Minimum(1.0, tuple(low for low, _ in domain), 1.0)

    def to_dict(self) -> dict[str, Any]:
        return {
            "grid": self.grid.tolist(),
            "ranges": [list(r) for r in self.ranges],
            "through": list(self.through),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], variables: int) -> "Lookup":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
        return cls(
            np.asarray(data["grid"], dtype=np.float64),
            tuple((float(low), float(high)) for low, high in data["ranges"]),
            tuple(str(name) for name in data["through"]),
        )
