"""Axes: where a table is integrated, and what a fit sees."""

import numbers
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ecfit.coordinates.maps import MAPS
from ecfit.errors import EcfitError, unknown

SPACINGS = {
    "uniform": "equally spaced nodes, both ends included",
    "gauss": "Gauss-Legendre nodes, ends excluded",
    "chebyshev": "Chebyshev-Lobatto nodes, both ends included",
    "texel-centre": "centres (i + 0.5) / N of N equal cells, ends excluded, as a texture is sampled",
    "given": "the nodes of the list `nodes`",
    "clamped": "nodes clip(linspace(0, 1), low, high) seen by fits as linspace(0, 1) "
    "(reproduces Sforza & Pellacini 2022)",
}
# Spacings whose first and last node lie inside the range.
_OPEN = ("gauss", "texel-centre")
# Far more than any grid has along one axis, and within any memory.
_MOST_NODES = 2**24


def _unit_nodes(spacing: str, count: int) -> np.ndarray:
    """`count` nodes of a spacing on [0, 1], increasing."""
    if spacing == "uniform":
        return np.linspace(0.0, 1.0, count)
    if spacing == "gauss":
        return 0.5 * (np.polynomial.legendre.leggauss(count)[0] + 1.0)
    if spacing == "chebyshev":
        # sin^2 keeps full relative precision near 0, where 1 - cos would cancel.
        return np.sin(0.5 * np.pi * np.arange(count) / (count - 1)) ** 2
    if spacing == "texel-centre":
        return (np.arange(count) + 0.5) / count
    raise unknown("spacing", spacing, SPACINGS)


@dataclass(frozen=True, eq=False)
class Axis:
    """One coordinate of a table.

    Attributes:
        name: the coordinate ("mu", "r", "alpha", "F0", "ior", or a parameter of the user's model).
        nodes: true coordinates where the integral is taken, float64, shape (count,), not decreasing.
        nominal: coordinates that a fit sees, strictly increasing; equal to `nodes` unless `clamped`.
        spacing: a name of `SPACINGS`.
        through: the named map y = map(t) such that the spacing holds in t.
        low, high: range of the nominal coordinate: the domain of a fit.

    Raises `EcfitError` for fewer than 2 nodes, nodes that are not finite numbers or do not increase, and
    unknown names.
    """

    name: str
    nodes: np.ndarray
    nominal: np.ndarray
    spacing: str = "given"
    through: str = "identity"
    low: float = field(default=np.nan)
    high: float = field(default=np.nan)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise EcfitError(f"an axis needs a name, got {self.name!r}")
        for label in ("nodes", "nominal"):
            try:
                array = np.array(getattr(self, label), dtype=np.float64)
            except (TypeError, ValueError):
                raise EcfitError(f"axis '{self.name}': {label} must be a list of numbers") from None
            if array.ndim != 1 or array.size < 2:
                raise EcfitError(f"axis '{self.name}': needs at least 2 {label}, got shape {array.shape}")
            if not np.all(np.isfinite(array)):
                raise EcfitError(f"axis '{self.name}': {label} must be finite")
            array.setflags(write=False)
            object.__setattr__(self, label, array)
        if self.nodes.shape != self.nominal.shape:
            raise EcfitError(f"axis '{self.name}': nodes and nominal coordinates differ in number")
        if np.any(np.diff(self.nominal) <= 0.0) or np.any(np.diff(self.nodes) < 0.0):
            raise EcfitError(f"axis '{self.name}': nodes must increase")
        for kind, given, valid in (("spacing", self.spacing, SPACINGS), ("map", self.through, MAPS)):
            if not isinstance(given, str) or given not in valid:
                raise unknown(kind, given, valid)
        if np.isnan(self.low):
            object.__setattr__(self, "low", float(self.nominal[0]))
        if np.isnan(self.high):
            object.__setattr__(self, "high", float(self.nominal[-1]))

    @classmethod
    def spaced(
        cls,
        name: str,
        count: int,
        low: float = 0.0,
        high: float = 1.0,
        spacing: str = "uniform",
        through: str = "identity",
    ) -> "Axis":
        """`count` nodes of a named spacing on [low, high], spaced in t where coordinate = map(t).

        Raises `EcfitError` for an unknown spacing or map, fewer than 2 nodes or more than 2^24, or an empty
        range.
        """
        if not isinstance(count, numbers.Integral) or isinstance(count, bool) or count < 2:
            raise EcfitError(f"axis '{name}': count must be an integer >= 2, got {count!r}")
        try:
            low, high = float(low), float(high)
        except (TypeError, ValueError, OverflowError):
            raise EcfitError(f"axis '{name}': the ends of its range must be numbers") from None
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise EcfitError(f"axis '{name}': needs a finite range with low < high, got [{low}, {high}]")
        if not isinstance(through, str) or through not in MAPS:
            raise unknown("map", through, MAPS)
        if count > _MOST_NODES:
            raise EcfitError(f"axis '{name}': count must be {_MOST_NODES} or less, got {count}")
        count = int(count)
        if spacing == "given":
            raise EcfitError(f"axis '{name}': spacing 'given' needs its nodes, not a count")
        if spacing == "clamped":
            if through != "identity":
                raise EcfitError(f"axis '{name}': a clamped axis takes no map")
            if not (low >= 0.0 and high <= 1.0):
                raise EcfitError(f"axis '{name}': a clamped axis lies in [0, 1], got [{low}, {high}]")
            nominal = np.linspace(0.0, 1.0, count)
            return cls(name, np.clip(nominal, low, high), nominal, spacing)
        map_ = MAPS[through]
        ends = np.array([low, high])
        with np.errstate(all="ignore"):
            t_low, t_high = map_.inverse(ends)
            back = map_.forward(np.array([t_low, t_high]))
        # An end that the map does not reach does not come back from it.
        if not (map_.low <= t_low < t_high <= map_.high and np.allclose(back, ends, rtol=1e-9, atol=1e-12)):
            raise EcfitError(f"axis '{name}': [{low}, {high}] is outside the range of the map '{through}'")
        nodes = np.asarray(map_.forward(t_low + (t_high - t_low) * _unit_nodes(spacing, count)))
        if spacing not in _OPEN:
            nodes[0], nodes[-1] = low, high  # exact ends, whatever the map's rounding
        return cls(name, nodes, nodes, spacing, through, float(low), float(high))

    @classmethod
    def given(cls, name: str, nodes: Sequence[Any] | np.ndarray) -> "Axis":
        """An axis with the given increasing nodes, shape (count,) with count >= 2; its range ends with them.

        Raises `EcfitError` for nodes that are not finite numbers, or do not increase.
        """
        return cls(name, nodes, nodes)  # type: ignore[arg-type]

    @property
    def clamped(self) -> bool:
        """Whether a fit sees other coordinates than those of the integral."""
        return self.spacing == "clamped"

    @property
    def fingerprint(self) -> bytes:
        """Everything that the axis says, for content hashes."""
        head = repr((self.name, self.spacing, self.through, self.low, self.high)).encode()
        return head + self.nodes.tobytes() + self.nominal.tobytes()

    def __len__(self) -> int:
        return self.nodes.size

    def describe(self) -> str:
        """One line: `r: 64 nodes, uniform in [0, 1]`."""
        through = "" if self.through == "identity" else f" through {MAPS[self.through].formula}"
        if self.clamped:
            where = f"clamped to [{self.nodes[0]:g}, {self.nodes[-1]:g}], seen as uniform in [0, 1]"
        else:
            where = f"{self.spacing} in [{self.low:g}, {self.high:g}]{through}"
        return f"{self.name}: {len(self)} nodes, {where}"
