"""A formula written out as text: how published approximations of any shape are kept as data."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ecfit.approximation.formula import Array, Box, Formula, broadcast
from ecfit.expressions import Node, parse, substitute, value, var
from ecfit.expressions.node import topological
from ecfit.forms import Minimum


@dataclass(frozen=True, eq=False)
class Written(Formula):
    """Text of the value in named variables, with definitions before it; see `ecfit.expressions.parse`.

    Attributes:
        names: of the variables, in order.
        text: the value.
        lets: (name, text) pairs defined before it.
        numbers: how many free numbers its author counts, where that is known; the distinct constants other
            than small integers otherwise.
    """

    kind: ClassVar[str] = "written"

    names: tuple[str, ...]
    text: str
    lets: tuple[tuple[str, str], ...] = ()
    numbers: int = 0

    def __post_init__(self) -> None:
        _ = self._expression  # a wrong formula fails here

    @cached_property
    def _expression(self) -> Node:
        return parse(self.text, self.names, self.lets)

    @property
    def variables(self) -> int:
        return len(self.names)

    @property
    def coefficients(self) -> np.ndarray:
        found = {abs(n.value) for n in topological([self._expression]) if n.op == "const"}
        return np.array(sorted(v for v in found if v != int(v) or v > 10.0))

    @property
    def count(self) -> int:
        """Numbers to store."""
        return self.numbers or self.coefficients.size

    def expression(self, names: Sequence[str]) -> Node:
        return substitute(self._expression, {a: var(b) for a, b in zip(self.names, names, strict=True)})

    def landmarks(self, names: Sequence[str]) -> dict[str, Node]:
        put = {a: var(b) for a, b in zip(self.names, names, strict=True)}
        known = [(name, parse(name, self.names, self.lets)) for name, _ in self.lets]
        return {name: substitute(node, put) for name, node in known}

    def value(self, points: Sequence[Array]) -> Array:
        arrays = broadcast(points)
        return value(self._expression, dict(zip(self.names, arrays, strict=True))) + 0 * arrays[0]

    def smallest_denominator(self, domain: Box) -> Minimum:
        return smallest_divisor(self._expression, self.names, domain)

    def to_dict(self) -> dict[str, Any]:
        return {
            "formula": self.text,
            "let": [list(pair) for pair in self.lets],
            "names": list(self.names),
            "numbers": self.numbers,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], variables: int) -> "Written":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
        lets = tuple((str(n), str(t)) for n, t in data.get("let", ()))
        names = tuple(str(n) for n in data.get("names", data["variables"]))
        return cls(names, str(data["formula"]), lets, int(data.get("numbers", 0)))


def smallest_divisor(root: Node, names: Sequence[str], domain: Box) -> Minimum:
    """The minimum over a box of the divisor that comes nearest to 0 of all divisions in an expression."""
    divisors = {id(n.args[1]): n.args[1] for n in topological([root]) if n.op == "div"}
    found = [interval_minimum(q, names, domain) for q in divisors.values() if q.op != "const"]
    return min(found, key=lambda m: m.bound, default=Minimum(1.0, tuple(lo for lo, _ in domain), 1.0))


def interval_minimum(q: Node, names: Sequence[str], domain: Box) -> Minimum:
    """The minimum of |q| over a box, by intervals: its sign at the centre decides which is meant."""
    from ecfit.expressions.bounds import smallest

    centre = {n: np.float64(0.5 * (low + high)) for n, (low, high) in zip(names, domain, strict=True)}
    positive = q if value(q, centre) >= 0.0 else -q
    return smallest(positive, dict(zip(names, domain, strict=True)))
