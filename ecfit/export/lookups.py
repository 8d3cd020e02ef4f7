"""A table as a function: linear interpolation in an array of constants, where the language has arrays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ecfit.approximation import Approximation, Lookup
from ecfit.coordinates import MAPS
from ecfit.errors import EcfitError
from ecfit.export.coordinates import Arguments
from ecfit.export.languages import Language
from ecfit.export.literals import literal
from ecfit.export.statements import statements, wrapped
from ecfit.expressions import Node, parse, substitute, var
from ecfit.expressions.fold import folded

_WIDTH = 100


@dataclass(frozen=True)
class TableFunction:
    """A function that reads a table linearly; `Function` is the same for formulas.

    Attributes:
        name, arguments, note: as of a function.
        grid: the values; the last of `places` varies fastest.
        places: for each dimension, the place among its nodes, 0 to count - 1, as an expression of the
            arguments.
    """

    name: str
    arguments: tuple[str, ...]
    note: str
    grid: np.ndarray
    places: tuple[Node, ...]

    def written(self, target: Language) -> list[str]:
        """Lines of the array and of the function. Raises `EcfitError` for languages without such arrays."""
        if not target.array:
            raise EcfitError(
                f"a table is no formula: in {target.title} it is a texture; as code it is for C and C++ only"
            )
        given = ", ".join(target.argument.format(name=a, type=target.real) for a in self.arguments)
        head = target.signature.format(result=target.real, name=self.name, arguments=given)
        body = [f"    {line}" for line in self._body(target)]
        return [
            *self._array(target),
            "",
            f"{target.comment}{self.note}",
            *head.splitlines(),
            *body,
            target.end,
        ]

    def _array(self, target: Language) -> list[str]:
        numbers = [literal(float(v), suffix=target.suffix) for v in self.grid.ravel()]
        lines, line = [], "   "
        for number in numbers:
            if len(line) + len(number) + 2 > _WIDTH:
                lines.append(line)
                line = "   "
            line += f" {number},"
        size = " * ".join(map(str, self.grid.shape))
        return [target.array.format(name=f"{self.name}_values", size=size), *lines, line, "};"]

    def _body(self, target: Language) -> list[str]:
        lines: list[str] = []
        taken = {self.name, *self.arguments, "at", "values"}
        for i, (place, count) in enumerate(zip(self.places, self.grid.shape, strict=True)):
            body, value = statements(place, target, {}, taken, stem=f"t{i + 1}_1")
            lines += body
            template = target.declare.format(name=f"x{i}", value="{value}", type=target.real)
            lines += wrapped(template, value, target)
            last = literal(float(count - 2), suffix=target.suffix)
            lines.append(f"const int i{i} = x{i} < {last} ? (int)x{i} : {count - 2};")
            lines.append(f"const float f{i} = x{i} - (float)i{i};")
        flat = "i0"
        for i, count in enumerate(self.grid.shape[1:], 1):
            flat = f"{flat if i == 1 else f'({flat})'} * {count} + i{i}"
        lines.append(f"const float *const at = {self.name}_values + ({flat});")
        strides = [int(np.prod(self.grid.shape[i + 1 :])) for i in range(self.grid.ndim)]
        corners = np.ndindex(*[2] * self.grid.ndim)
        level = [f"at[{sum(s * b for s, b in zip(strides, c, strict=True))}]" for c in corners]
        for i in reversed(range(self.grid.ndim)):
            pairs, level = list(zip(level[::2], level[1::2], strict=True)), []
            for k, (a, b) in enumerate(pairs):
                lines.append(f"const float y{i}{k} = {a} + f{i} * ({b} - {a});")
                level.append(f"y{i}{k}")
        return [*lines, f"return {level[0]};"]


def table_function(approximation: Approximation, name: str, taken: Arguments) -> TableFunction:
    """The function that reads a `Lookup`; `taken` must clamp its arguments."""
    formula = approximation.formula
    assert isinstance(formula, Lookup)
    rows = zip(approximation.variables, formula.grid.shape, formula.ranges, formula.through, strict=True)
    places = tuple(folded(taken.transform(_place(*row))) for row in rows)
    note = f"{approximation.contract.quantity} of {approximation.contract.model}, read linearly in a table"
    return TableFunction(name, taken.names, note, formula.grid, places)


def _place(variable: str, count: int, ends: Sequence[float], through: str) -> Node:
    """Where a value lies among nodes that are uniform in t, x = map(t)."""
    inverse = MAPS[through].inverse
    start, end = float(inverse(ends[0])), float(inverse(ends[1]))
    text = MAPS[through].inverse_formula.partition("= ")[2].replace("^", "**")
    t = substitute(parse(text, ("y",)), {"y": var(variable)})
    return (t - start) * ((count - 1) / (end - start))
