"""The slope of an exported function by one of its arguments."""

import numpy as np

from ecfit.errors import EcfitError, unknown
from ecfit.export.coordinates import Arguments
from ecfit.export.functions import Function
from ecfit.export.lookups import TableFunction
from ecfit.expressions import Node, derivative, maximum, value, var
from ecfit.expressions.fold import folded
from ecfit.expressions.node import replaced, topological

# Where roots have no slope, at 0, the slope here is given, as values have it for mu (`forms.structured`).
NEAR_ZERO = 1e-6


def slope(function: Function | TableFunction, taken: Arguments, argument: str) -> Function:
    """The derivative of a function by one of its arguments, a number on the whole closed domain.

    By the chain rule a root of x has no slope at x = 0, where that of the function mostly has a limit
    (0 times infinity). Arguments that reach 0 there are raised to `NEAR_ZERO`: in the slope only, and not in
    comparisons (of limits), which ask where an argument is.

    Args:
        taken: the function's arguments with their domain.

    Raises `EcfitError` for other arguments and for tables.
    """
    if isinstance(function, TableFunction):
        raise EcfitError("a table has no derivative to export: take differences of its values")
    if argument not in function.arguments:
        raise unknown("argument for a derivative", argument, function.arguments)
    found = folded(derivative(function.value, argument))
    raised = {var(n): maximum(var(n), NEAR_ZERO) for n in taken.names if _lost_at_zero(found, taken, n)}

    def tidied(node: Node) -> Node:
        kept = {n: n for n in topological([node]) if n.op == "step"} if raised else {}
        return folded(replaced(node, {**raised, **kept}))

    note = f"d {function.name} / d {argument}"
    name = f"{function.name}_d{argument}"
    meanings = {tidied(node): meaning for node, meaning in function.meanings.items()}
    return Function(name, function.arguments, tidied(found), note, meanings=meanings)


def _lost_at_zero(node: Node, taken: Arguments, name: str) -> bool:
    """Whether an argument's domain begins at 0, and the value there, amid those of others, is no number."""
    ends = dict(zip(taken.names, taken.domain, strict=True))
    # Some domains end at infinity, as that of ior for F0 = 1 does.
    middle = {n: np.float64(0.5 * (low + min(high, low + 1.0))) for n, (low, high) in ends.items()}
    return ends[name][0] == 0.0 and not np.isfinite(value(node, {**middle, name: np.float64(0.0)}))
