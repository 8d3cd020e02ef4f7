"""A function as text of a language, from its arguments and the expression that it returns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ecfit.export.languages import Language
from ecfit.export.statements import statements, wrapped
from ecfit.expressions import Node


@dataclass(frozen=True)
class Function:
    """What a function computes, in any language.

    Attributes:
        name: of the function.
        arguments: names, in order; expressions are in terms of them and of `calls`.
        value: the expression that it returns.
        note: what it is, for the reader of the code.
        calls: locals that hold the value of a call: name -> (function, arguments).
        colours: which arguments are RGB values; the result is one where any is.
        meanings: names for subexpressions that have a meaning.
    """

    name: str
    arguments: tuple[str, ...]
    value: Node
    note: str
    calls: Mapping[str, tuple[str, Sequence[str]]] = field(default_factory=dict)
    colours: frozenset[str] = frozenset()
    meanings: Mapping[Node, str] = field(default_factory=dict)

    def written(self, target: Language) -> list[str]:
        """Lines of the function with a line of comment before it."""
        result = target.colour if self.colours else target.real
        arguments = [
            target.argument.format(name=a, type=target.colour if a in self.colours else target.real)
            for a in self.arguments
        ]
        signature = target.signature.format(result=result, name=self.name, arguments=", ".join(arguments))
        lines = []
        for local, (function, given) in self.calls.items():
            call = f"{function}({', '.join(given)}{', xp=xp' * (target.name == 'python')})"
            lines.append(target.declare.format(name=local, value=call, type=target.real))
        taken = {self.name, *self.arguments, *self.calls, "xp", "numpy"}
        body, value = statements(self.value, target, self.meanings, taken)
        lines += [*body, *wrapped(f"return {{value}}{target.stop}", value, target)]
        end = [target.end] if target.end else []
        return [f"{target.comment}{self.note}", *signature.splitlines(), *(f"    {x}" for x in lines), *end]
