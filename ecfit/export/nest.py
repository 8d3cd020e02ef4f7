"""Sums of products in nested form: what structured forms have by themselves, for published formulas."""

import numpy as np

from ecfit.expressions import Node, cost
from ecfit.expressions.node import rebuild, topological
from ecfit.forms.nested import nested

# A sum as numbers times powers of other expressions.
_Terms = list[tuple[float, dict[Node, int]]]


def nested_sums(root: Node) -> Node:
    """The expression with each sum of products nested where that saves operations: equal in exact algebra."""
    done: dict[Node, Node] = {}
    inner = _inner_sums(root)
    for node in topological([root]):
        made = rebuild(node.op, [done[a] for a in node.args], node.value, node.name)
        done[node] = made if node in inner or node.op not in ("add", "sub") else _nested(made)
    return done[root]


def _inner_sums(root: Node) -> set[Node]:
    """Sums that are summands themselves, and of nothing else."""
    summands, others = set[Node](), {root}
    for node in topological([root]):
        (summands if node.op in ("add", "sub") else others).update(node.args)
    return summands - others


def _nested(node: Node) -> Node:
    terms = _terms(node, 1.0)
    bases = list(dict.fromkeys(b for _, powers in terms for b in powers))
    if len(terms) < 3 or not bases:
        return node
    merged: dict[tuple[int, ...], float] = {}
    for c, powers in terms:
        row = tuple(powers.get(b, 0) for b in bases)
        merged[row] = merged.get(row, 0.0) + c
    names = [str(i) for i in range(len(bases))]
    exponents = np.array(list(merged), dtype=np.float64)
    made = nested(exponents, np.array(list(merged.values())), names, dict(zip(names, bases, strict=True)))
    return made if cost(made).total < cost(node).total else node


def _terms(node: Node, sign: float) -> _Terms:
    if node.op == "neg":
        return _terms(node.args[0], -sign)
    if node.op in ("add", "sub"):
        x, y = node.args
        return _terms(x, sign) + _terms(y, sign if node.op == "add" else -sign)
    c, powers = sign, dict[Node, int]()
    stack = [node]
    while stack:
        factor = stack.pop()
        if factor.op == "mul":
            stack += factor.args
        elif factor.op == "const":
            c *= factor.value
        elif factor.op == "neg":
            c = -c
            stack.append(factor.args[0])
        else:
            powers[factor] = powers.get(factor, 0) + 1
    return [(c, powers)]
