"""Derivatives of expressions, as expressions."""

import math

from ecfit.expressions.node import Node, const, power, step, topological


def derivative(root: Node, name: str) -> Node:
    """d root / d name.

    At a kink it is the derivative on one side: of min and max, that of the argument which equals both, the
    first; of |x|, that for x >= 0. Where the function has an infinite slope (sqrt at 0), it is not finite.
    """
    done: dict[Node, Node] = {}
    for node in topological([root]):
        if node.op == "var":
            done[node] = const(1.0 if node.name == name else 0.0)
        else:
            done[node] = _of(node, [done[a] for a in node.args])
    return done[root]


def _of(node: Node, slopes: list[Node]) -> Node:
    if all(s.op == "const" and s.value == 0.0 for s in slopes):
        return const(0.0)
    (x, *rest), dx = node.args, slopes[0]
    if rest:
        return _of_two(node, x, rest[0], dx, slopes[1])
    if node.op == "neg":
        return -dx
    if node.op == "sqrt":
        return dx / (2.0 * node)
    if node.op == "exp":
        return dx * node
    if node.op == "exp2":
        return dx * node * math.log(2.0)
    if node.op == "log":
        return dx / x
    if node.op == "abs":
        return dx * (2.0 * step(x, 0.0) - 1.0)
    return dx * (power(x, node.value - 1.0) * node.value)  # pow


def _of_two(node: Node, x: Node, y: Node, dx: Node, dy: Node) -> Node:
    if node.op == "add":
        return dx + dy
    if node.op == "sub":
        return dx - dy
    if node.op == "mul":
        return (dx * x) * 2.0 if x is y else dx * y + x * dy
    if node.op == "div":
        return (dx - node * dy) / y
    if node.op == "step":
        return const(0.0)
    first = step(y, x) if node.op == "min" else step(x, y)
    return first * dx + (1.0 - first) * dy
