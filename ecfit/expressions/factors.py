"""Expressions as products of powers: a sum whose terms share a factor touches 0 where the factor does.

Bounds alone cannot prove u^5 - u X >= 0 at u = 0; written as u (u^4 - X), each factor's sign can be proved
by itself.
"""

from collections.abc import Callable, Mapping

from ecfit.expressions.node import Node, const, power, topological

# base -> exponent, negative for divisors.
Factors = dict[Node, float]

_ONE = const(1.0)


def factors(root: Node, positive: Callable[[Node], bool]) -> Factors:
    """The product of powers that an expression is, with what the terms of its sums share taken out.

    Equal to the expression wherever no divisor is 0. Sums over different divisors get a common one.

    Args:
        root: the expression.
        positive: whether an expression is known to be >= 0 on the domain: only then is a square root taken
            factor by factor.
    """
    found: dict[int, Factors] = {}
    for node in topological([root]):
        arguments = [found[id(a)] for a in node.args]
        found[id(node)] = _factors(node, arguments, positive)
    return found[id(root)]


def _factors(node: Node, arguments: list[Factors], positive: Callable[[Node], bool]) -> Factors:
    if node is _ONE:
        return {}
    if node.op == "mul":
        return _times(arguments[0], arguments[1], 1.0)
    if node.op == "div":
        return _times(arguments[0], arguments[1], -1.0)
    if node.op == "neg":
        return _times(arguments[0], {const(-1.0): 1.0}, 1.0)
    if node.op == "sqrt" and all(positive(base) for base in arguments[0]):
        return {base: 0.5 * exponent for base, exponent in arguments[0].items()}
    if node.op in ("add", "sub"):
        x, y = arguments
        shared = {b: min(x.get(b, 0.0), y.get(b, 0.0)) for b in {**x, **y}}
        shared = {b: e for b, e in shared.items() if e}
        if shared:
            left, right = product(_times(x, shared, -1.0)), product(_times(y, shared, -1.0))
            core = left + right if node.op == "add" else left - right
            return _times(shared, _of_core(core), 1.0)
    return {node: 1.0}


def _of_core(core: Node) -> Factors:
    return {} if core is _ONE else {core: 1.0}


def _times(x: Factors, y: Factors, sign: float) -> Factors:
    out = dict(x)
    for base, exponent in y.items():
        out[base] = out.get(base, 0.0) + sign * exponent
    return {base: exponent for base, exponent in out.items() if exponent}


def product(parts: Mapping[Node, float]) -> Node:
    """The expression of a product of powers with exponents >= 0."""
    out = _ONE
    for base, exponent in parts.items():
        out = out * power(base, exponent)
    return out
