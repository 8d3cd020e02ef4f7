"""An expression as statements of a language: named locals, and a value in terms of them.

Nothing is computed in another order than the expression says: signs move (a + (-c) b is a - c b, exactly) and
factors and summands of two change places, which no rounding notices.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from ecfit.export.languages import Language
from ecfit.export.literals import literal
from ecfit.export.naming import named
from ecfit.expressions import Node

# How tightly a text binds: what is looser than its place asks for gets brackets.
_SUM, _PRODUCT, _SIGNED, _ATOM = range(4)
_WIDTH = 100
_OPERATORS = frozenset("+-*/<>?:")


class _Text(NamedTuple):
    text: str
    binds: int

    def at(self, least: int) -> str:
        return self.text if self.binds >= least else f"({self.text})"


def statements(
    root: Node, target: Language, meanings: Mapping[Node, str], taken: Iterable[str]
) -> tuple[list[str], str]:
    """Definitions of locals, one a line (a long one on several), and the value.

    Args:
        root: the expression; its inputs are names in the language.
        target: the language.
        meanings: names for subexpressions that have a meaning.
        taken: names that locals must not have.
    """
    repeats = [op for op, text in target.calls.items() if text.count("{0}") > 1 or text.count("{1}") > 1]
    names = named([root], meanings, {*taken, *target.keywords}, repeats)
    writer = _Writer(target, names)
    lines: list[str] = []
    for node, name in names.items():
        text = target.declare.format(name=name, value="{value}", type=target.real)
        lines += wrapped(text, writer.operation(node).text, target)
    return lines, writer.text(root).text


def wrapped(template: str, value: str, target: Language, indent: int = 4) -> list[str]:
    """A statement as lines of at most 100 characters, broken before operators, outermost ones first."""
    whole = template.format(value=value)
    if len(whole) + indent <= _WIDTH:
        return [whole]
    opened, closed = target.joined or ("", "")
    pieces, left = [], template.format(value=opened + value + closed)
    room = _WIDTH - indent
    while len(left) > room:
        cut = _break(left, room)
        if cut is None:
            break
        pieces.append(left[:cut].rstrip())
        left = left[cut:]
        room = _WIDTH - indent - 4
    return [pieces[0], *(f"    {p}" for p in (*pieces[1:], left))] if pieces else [left]


def _break(text: str, room: int) -> int | None:
    """Before which operator to break: the outermost of the last two thirds of the line, sums first."""
    depth, found = 0, list[tuple[int, bool, int]]()
    for i, letter in enumerate(text[: room + 1]):
        depth += (letter in "([") - (letter in ")]")
        if letter in _OPERATORS and text[i - 1] == " " and text[i + 1 : i + 2] == " " and i > 8:
            found.append((depth, letter in "*/", -i))
    late = [f for f in found if -f[2] > room // 3] or found
    return -min(late)[2] if late else None


class _Writer:
    def __init__(self, target: Language, names: Mapping[Node, str]) -> None:
        self.target, self.names = target, names
        self._known: dict[Node, _Text] = {}

    def text(self, node: Node) -> _Text:
        """The text where the node is used: its name, if it has one."""
        if node in self.names:
            return _Text(self.names[node], _ATOM)
        if node not in self._known:
            self._known[node] = self.operation(node)
        return self._known[node]

    def operation(self, node: Node) -> _Text:
        """The text of the operation itself, in terms of its arguments' texts."""
        if node.op == "const":
            return self._literal(node.value)
        if node.op == "var":
            return _Text(node.name, _ATOM)
        if node.op == "neg":
            return _Text("-" + self.text(node.args[0]).at(_ATOM), _SIGNED)
        if node.op in ("add", "sub"):
            return self._sum(node)
        if node.op in ("mul", "div"):
            return self._product(node, 1.0)
        arguments = [self.text(a).text for a in node.args]
        if node.op == "pow":
            arguments.append(self._literal(node.value).text)
        return _Text(self.target.calls[node.op].format(*arguments), _ATOM)

    def _literal(self, value: float) -> _Text:
        text = literal(value, double=self.target.double, suffix=self.target.suffix)
        return _Text(text, _SIGNED if text.startswith("-") else _ATOM)

    def _sum(self, node: Node) -> _Text:
        x, y = node.args
        minus = node.op == "sub"
        if self._negative(y):
            minus, y = not minus, self._opposite(y)
        elif not minus and self._negative(x):
            return _Text(f"{self.text(y).at(_SUM)} - {self._opposite(x).at(_PRODUCT)}", _SUM)
        right = y if isinstance(y, _Text) else self.text(y)
        return _Text(f"{self.text(x).at(_SUM)} {'-' if minus else '+'} {right.at(_PRODUCT)}", _SUM)

    def _product(self, node: Node, sign: float) -> _Text:
        """A product or quotient, times a sign that one of its numbers takes."""
        x, y = node.args
        left, right = self.text(x), self.text(y)
        if sign < 0.0:
            if self._negative(x):
                left = self._opposite(x)
            else:
                right = self._opposite(y)
        if node.op == "mul":
            if (y.op == "const" and left.binds == _ATOM) or left.binds == _SUM < right.binds == _PRODUCT:
                left, right = right, left
            return _Text(f"{left.at(_PRODUCT)} * {right.at(_ATOM)}", _PRODUCT)
        return _Text(f"{left.at(_PRODUCT)} / {right.at(_ATOM)}", _PRODUCT)

    def _negative(self, node: Node) -> bool:
        """Whether the text of a node without its sign is that of the opposite."""
        if node in self.names:
            return False
        if node.op == "const":
            return node.value < 0.0
        if node.op == "mul":
            return any(self._negative(a) for a in node.args)
        return node.op == "neg" or (node.op == "div" and self._negative(node.args[0]))

    def _opposite(self, node: Node) -> _Text:
        if node.op == "const":
            return self._literal(-node.value)
        if node.op == "neg":
            return self.text(node.args[0])
        return self._product(node, -1.0)
