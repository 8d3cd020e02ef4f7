"""Nodes of an expression tree: immutable, and one object for each distinct subexpression."""

import math
from collections.abc import Mapping, Sequence
from weakref import WeakValueDictionary

# Operations and their number of arguments. `const` holds a value, `var` a name, `pow` its constant exponent.
ARITY = {
    "const": 0, "var": 0, "neg": 1, "sqrt": 1, "exp": 1, "exp2": 1, "log": 1, "abs": 1, "pow": 1,
    "add": 2, "sub": 2, "mul": 2, "div": 2, "min": 2, "max": 2,
}  # fmt: skip


class Node:
    """One operation on other nodes. Made by the functions below and by arithmetic on nodes."""

    __slots__ = ("__weakref__", "args", "name", "op", "value")

    op: str
    args: tuple["Node", ...]
    value: float
    name: str

    def __init__(self, op: str, args: tuple["Node", ...], value: float, name: str) -> None:
        self.op, self.args, self.value, self.name = op, args, value, name

    def __add__(self, other: "Node | float") -> "Node":
        other = _node(other)
        if _is(self, 0.0):
            return other
        return self if _is(other, 0.0) else _make("add", self, other)

    def __radd__(self, other: float) -> "Node":
        return _node(other) + self

    def __sub__(self, other: "Node | float") -> "Node":
        other = _node(other)
        if _is(self, 0.0):
            return -other
        return self if _is(other, 0.0) else _make("sub", self, other)

    def __rsub__(self, other: float) -> "Node":
        return _node(other) - self

    def __mul__(self, other: "Node | float") -> "Node":
        other = _node(other)
        if _is(self, 1.0) or _is(other, 0.0):
            return other
        return self if _is(other, 1.0) or _is(self, 0.0) else _make("mul", self, other)

    def __rmul__(self, other: float) -> "Node":
        return _node(other) * self

    def __truediv__(self, other: "Node | float") -> "Node":
        other = _node(other)
        return self if _is(other, 1.0) else _make("div", self, other)

    def __rtruediv__(self, other: float) -> "Node":
        return _node(other) / self

    def __neg__(self) -> "Node":
        return const(-self.value) if self.op == "const" else _make("neg", self)

    def __repr__(self) -> str:
        if self.op == "const":
            return repr(self.value)
        if self.op == "var":
            return self.name
        rest = f", {self.value:g}" if self.op == "pow" else ""
        return f"{self.op}({', '.join(map(repr, self.args))}{rest})"


_known: WeakValueDictionary[tuple, Node] = WeakValueDictionary()


def _make(op: str, *args: Node, value: float = 0.0, name: str = "") -> Node:
    # Arguments are interned and kept alive by the node, so their ids identify them. The sign of 0 counts.
    key = (op, tuple(map(id, args)), value, math.copysign(1.0, value), name)
    found = _known.get(key)
    if found is None:
        found = _known[key] = Node(op, args, value, name)
    return found


def _node(x: "Node | float") -> Node:
    return x if isinstance(x, Node) else const(x)


def _is(x: Node, value: float) -> bool:
    return x.op == "const" and x.value == value


def const(value: float) -> Node:
    """A number."""
    return _make("const", value=float(value))


def var(name: str) -> Node:
    """An input."""
    return _make("var", name=name)


def sqrt(x: "Node | float") -> Node:
    """The square root."""
    return _make("sqrt", _node(x))


def minimum(x: "Node | float", y: "Node | float") -> Node:
    """The lesser of two."""
    return _make("min", _node(x), _node(y))


def maximum(x: "Node | float", y: "Node | float") -> Node:
    """The greater of two."""
    return _make("max", _node(x), _node(y))


def unary(op: str, x: "Node | float") -> Node:
    """exp, exp2, log or abs of x."""
    return _make(op, _node(x))


def power(x: "Node | float", exponent: float) -> Node:
    """x to a constant exponent, in products and square roots where it is a multiple of 1/4.

    The powers of one x share their factors: x^3 is x * x^2 wherever x^2 occurs too.
    """
    x = _node(x)
    if exponent < 0.0:
        return 1.0 / power(x, -exponent)
    whole = int(exponent)
    rest = exponent - whole
    if whole > 64 or rest not in (0.0, 0.25, 0.5, 0.75):
        return _make("pow", x, value=float(exponent))
    out = _integer_power(x, whole)
    if rest:
        root = sqrt(x)
        quarter = sqrt(root) if rest != 0.5 else None
        part = root if quarter is None else quarter if rest == 0.25 else root * quarter
        out = part if whole == 0 else out * part
    return out


def _integer_power(x: Node, n: int) -> Node:
    if n == 0:
        return const(1.0)
    if n == 1:
        return x
    half = _integer_power(x, n // 2)
    return half * half if n % 2 == 0 else _integer_power(x, n - 1) * x


def topological(roots: Sequence[Node]) -> list[Node]:
    """All nodes under `roots`, each once, arguments before what uses them."""
    seen: set[int] = set()
    order: list[Node] = []
    stack: list[tuple[Node, bool]] = [(r, False) for r in reversed(roots)]
    while stack:
        node, ready = stack.pop()
        if ready:
            order.append(node)
        elif id(node) not in seen:
            seen.add(id(node))
            stack.append((node, True))
            stack.extend((a, False) for a in reversed(node.args))
    return order


def rebuild(op: str, args: Sequence[Node], value: float = 0.0, name: str = "") -> Node:
    """A node of an operation by name, with the simplifications of arithmetic on nodes."""
    if op == "add":
        return args[0] + args[1]
    if op == "sub":
        return args[0] - args[1]
    if op == "mul":
        return args[0] * args[1]
    if op == "div":
        return args[0] / args[1]
    if op == "neg":
        return -args[0]
    return _make(op, *args, value=value, name=name)


def substitute(root: Node, replacements: Mapping[str, Node]) -> Node:
    """The expression with inputs replaced by other expressions."""
    done: dict[int, Node] = {}
    for node in topological([root]):
        if node.op == "var":
            done[id(node)] = replacements.get(node.name, node)
        else:
            done[id(node)] = rebuild(node.op, [done[id(a)] for a in node.args], node.value, node.name)
    return done[id(root)]


def replaced(root: Node, replacements: Mapping[Node, Node]) -> Node:
    """The expression with subexpressions replaced by others."""
    done: dict[int, Node] = {}
    for node in topological([root]):
        found = replacements.get(node)
        if found is None:
            found = rebuild(node.op, [done[id(a)] for a in node.args], node.value, node.name)
        done[id(node)] = found
    return done[id(root)]


def with_roots(root: Node, put: Mapping[Node, Node]) -> Node:
    """The expression with subexpressions replaced, and sqrt(x x) written x where a replacement has x x.

    For replacements such as F0 = s s with s >= 0.
    """
    squares = {}
    for made in put.values():
        for part in topological([made]):
            if part.op == "mul" and part.args[0] is part.args[1]:
                squares[part] = part.args[0]
    done: dict[Node, Node] = {}
    for node in topological([root]):
        if node in put:
            done[node] = put[node]
        elif node.op == "sqrt":
            inner = done[node.args[0]]
            done[node] = squares[inner] if inner in squares else sqrt(inner)
        else:
            done[node] = rebuild(node.op, [done[a] for a in node.args], node.value, node.name)
    return done[root]


def inputs(root: Node) -> set[str]:
    """Names of the inputs."""
    return {n.name for n in topological([root]) if n.op == "var"}
