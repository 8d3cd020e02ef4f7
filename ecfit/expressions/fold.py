"""Expressions tidied without changing their values: constants formed once, limits within limits merged."""

import numpy as np

from ecfit.expressions.evaluate import value
from ecfit.expressions.node import Node, const, maximum, minimum, rebuild, topological


def folded(root: Node) -> Node:
    """The expression with operations on numbers alone carried out in double precision, and limits merged.

    A result that is not finite is left as the operation, so that the fault stays visible. Of limits,
    max(min(max(x, 0), 1), c) is min(max(x, c), 1) for c in [0, 1].
    """
    done: dict[int, Node] = {}
    for node in topological([root]):
        args = [done[id(a)] for a in node.args]
        made = rebuild(node.op, args, node.value, node.name)
        if made.args and all(a.op == "const" for a in made.args):
            number = float(value(made, {"": np.float64(0.0)}))
            made = const(number) if np.isfinite(number) else made
        done[id(node)] = _limited(made)
    return done[id(root)]


def _limited(node: Node) -> Node:
    """max(max(x, a), c) as one maximum, and max(min(x, b), c) as min(max(x, c), b) where c <= b."""
    if node.op != "max" or node.args[1].op != "const" or node.args[0].op not in ("min", "max"):
        return node
    inner, c = node.args
    x, bound = inner.args
    if bound.op != "const":
        return node
    if inner.op == "max":
        return maximum(x, max(bound.value, c.value))
    return minimum(_limited(maximum(x, c)), bound) if c.value <= bound.value else node
