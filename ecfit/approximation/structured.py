"""A structured form with its coefficients."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ecfit.approximation.formula import Array, Box, Formula, broadcast, power_product
from ecfit.approximation.written import interval_minimum
from ecfit.errors import EcfitError
from ecfit.expressions import Node, value
from ecfit.forms import Minimum, Structure
from ecfit.forms.corner import ChartDomain


@dataclass(frozen=True, eq=False)
class StructuredFormula(Formula):
    """A `Structure` and its coefficients: numerators one after the other, then Q without its leading 1.

    Raises `EcfitError` for coefficients that are not finite, or not as many as the structure has.
    """

    kind: ClassVar[str] = "structured"

    structure: Structure
    values: np.ndarray

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.float64)
        if values.shape != (self.structure.count,):
            raise EcfitError(f"{self.structure.count} coefficients expected, got shape {values.shape}")
        if not np.all(np.isfinite(values)):
            raise EcfitError("coefficients must be finite")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @property
    def variables(self) -> int:
        return len(self.structure.variables)

    @property
    def coefficients(self) -> np.ndarray:
        return self.values

    @cached_property
    def _expression(self) -> Node:
        return self.structure.expression(self.values)

    def expression(self, names: Sequence[str]) -> Node:
        if tuple(names) != self.structure.variables:
            raise EcfitError(f"this form is a function of {', '.join(self.structure.variables)}")
        return self._expression

    def landmarks(self, names: Sequence[str]) -> dict[str, Node]:
        return self.structure.landmarks(self.values)

    def value(self, points: Sequence[Array]) -> Array:
        arrays = broadcast(points)
        return (
            value(self._expression, dict(zip(self.structure.variables, arrays, strict=True))) + 0 * arrays[0]
        )

    def smallest_denominator(self, domain: Box) -> Minimum:
        """See `Formula`; of a form with the corner chart, Q divided by its lowest power of rho."""
        ranges = dict(zip(self.structure.variables, domain, strict=True))
        if not self.structure.corner:
            return interval_minimum(self.structure.denominator_expression(self.values), tuple(ranges), domain)
        # Q is 0 at alpha = mu = 0 by construction: what matters is Q' = Q / rho^order in the chart.
        chart = ChartDomain.of(ranges)
        found = chart.smallest(self.structure.chart(self.values)[-1])
        place = chart.place(dict(zip(chart.box, found.place, strict=True)))
        return found._replace(place=tuple(place[n] for n in ranges))

    def rows(self, names: Sequence[str]) -> list[tuple[str, float]]:
        structure, parts = self.structure, self.structure.split(self.values)
        labels = [*(f"P{i + 1}" for i in range(len(parts) - 1)), "Q"] if len(parts) > 2 else ["P", "Q"]
        groups = (*structure.numerators, structure.denominator)
        return [
            (f"{label}: {power_product(structure.features, row)}", float(c))
            for label, exponents, values in zip(labels, groups, parts, strict=True)
            for row, c in zip(exponents, values, strict=True)
        ]

    def to_dict(self) -> dict[str, Any]:
        return {"structure": self.structure.to_dict(), "coefficients": self.values.tolist()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], variables: int) -> "StructuredFormula":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
        return cls(Structure.from_dict(data["structure"]), np.asarray(data["coefficients"], dtype=np.float64))
