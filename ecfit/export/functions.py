"""A function as text of a language, from its arguments and the expression that it returns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ecfit.export.languages import Language
from ecfit.export.statements import statements, wrapped
from ecfit.expressions import Node
from ecfit.expressions.node import inputs


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
        used = inputs(self.value).union(*(given for _, given in self.calls.values()))
        lines = [target.unused.format(name=a) for a in self.arguments if target.unused and a not in used]
        for local, (function, given) in self.calls.items():
            call = f"{function}({', '.join(given)}{', xp=xp' * (target.name == 'python')})"
            lines.append(target.declare.format(name=local, value=call, type=target.real))
        called = (function for function, _ in self.calls.values())
        taken = {self.name, *self.arguments, *self.calls, *called}
        body, value = statements(self.value, target, self.meanings, taken)
        lines += [*body, *wrapped(f"return {{value}}{target.stop}", value, target)]
        end = [target.end] if target.end else []
        scalar = " (one call a channel)" * (bool(self.colours) and target.colour == target.real)
        return [
            f"{target.comment}{self.note}{scalar}",
            *signature.splitlines(),
            *(f"    {x}" for x in lines),
            *end,
        ]
