"""A formula of other formulas: R = E1 E_spec, A = E1 - B, and the like."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ecfit.approximation.formula import Array, Box, Formula, broadcast
from ecfit.approximation.structured import StructuredFormula
from ecfit.approximation.written import Written
from ecfit.errors import EcfitError, unknown
from ecfit.expressions import Node, parse, substitute, value, var
from ecfit.forms import Minimum

KINDS: dict[str, Any] = {k.kind: k for k in (StructuredFormula, Written)}


@dataclass(frozen=True, eq=False)
class Part:
    """A formula inside another, and the variables of the whole that it is a function of."""

    name: str
    variables: tuple[str, ...]
    formula: Formula


@dataclass(frozen=True, eq=False)
class Composed(Formula):
    """Text in the names of parts, each a formula of some of the variables.

    Attributes:
        names: of the variables, in order.
        text: the value, such as "E1 * E_spec".
        parts: what the names in the text stand for.
    """

    kind: ClassVar[str] = "composed"

    names: tuple[str, ...]
    text: str
    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        names = [part.name for part in self.parts]
        if not names or len(set(names)) < len(names):
            raise EcfitError("a composed formula needs parts, each name once")
        for part in self.parts:
            if len(part.variables) != part.formula.variables:
                raise EcfitError(f"part '{part.name}' is a function of {part.formula.variables} variables")
            if not set(part.variables) <= set(self.names):
                raise EcfitError(f"part '{part.name}' is a function of more than {', '.join(self.names)}")
        _ = self._expression

    @cached_property
    def text_expression(self) -> Node:
        """The text, in the names of the parts."""
        return parse(self.text, [part.name for part in self.parts])

    @cached_property
    def _expression(self) -> Node:
        return substitute(
            self.text_expression, {p.name: p.formula.expression(p.variables) for p in self.parts}
        )

    @property
    def variables(self) -> int:
        return len(self.names)

    @property
    def coefficients(self) -> np.ndarray:
        return np.concatenate([part.formula.coefficients for part in self.parts])

    def expression(self, names: Sequence[str]) -> Node:
        return substitute(self._expression, {a: var(b) for a, b in zip(self.names, names, strict=True)})

    def landmarks(self, names: Sequence[str]) -> dict[str, Node]:
        put = {a: var(b) for a, b in zip(self.names, names, strict=True)}
        out = {}
        for part in self.parts:
            known = part.formula.landmarks(part.variables)
            out |= {f"{name}_{part.name}": node for name, node in known.items()}
            out[part.name] = part.formula.expression(part.variables)
        return {name: substitute(node, put) for name, node in out.items()}

    def value(self, points: Sequence[Array]) -> Array:
        arrays = broadcast(points)
        return value(self._expression, dict(zip(self.names, arrays, strict=True))) + 0 * arrays[0]

    def smallest_denominator(self, domain: Box) -> Minimum:
        box = dict(zip(self.names, domain, strict=True))
        centre = {name: 0.5 * (low + high) for name, (low, high) in box.items()}
        found = []
        for part in self.parts:
            least = part.formula.smallest_denominator([box[v] for v in part.variables])
            place = {**centre, **dict(zip(part.variables, least.place, strict=True))}
            found.append(least._replace(place=tuple(place[n] for n in self.names)))
        return min(found, key=lambda m: m.bound)

    def to_dict(self) -> dict[str, Any]:
        return {
            "text": self.text,
            "parts": [
                {
                    "name": p.name,
                    "variables": list(p.variables),
                    "kind": p.formula.kind,
                    **p.formula.to_dict(),
                }
                for p in self.parts
            ],
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], variables: int) -> "Composed":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
        parts = []
        for part in data["parts"]:
            if part["kind"] not in KINDS:
                raise unknown("kind of formula in a part", str(part["kind"]), KINDS)
            names = tuple(str(v) for v in part["variables"])
            formula = KINDS[part["kind"]].from_dict(part, len(names))
            parts.append(Part(str(part["name"]), names, formula))
        return cls(tuple(str(v) for v in data["variables"]), str(data["text"]), tuple(parts))
