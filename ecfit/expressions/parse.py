"""Formulas as text: arithmetic and a few functions, parsed without executing anything."""

import ast
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from ecfit.errors import EcfitError, did_you_mean
from ecfit.expressions.node import Node, const, maximum, minimum, power, sqrt, unary, var


def saturate(x: Node) -> Node:
    """x clipped to [0, 1]."""
    return minimum(maximum(x, 0.0), 1.0)


# name -> (number of arguments, builder)
_FUNCTIONS: dict[str, tuple[int, Callable[..., Node]]] = {
    "sqrt": (1, sqrt),
    "min": (2, minimum),
    "max": (2, maximum),
    "saturate": (1, saturate),
    **{op: (1, partial(unary, op)) for op in ("exp", "exp2", "log", "abs")},
}
_LONGEST = 20_000


def parse(
    text: str,
    names: Sequence[str],
    lets: Sequence[tuple[str, str]] = (),
    functions: Mapping[str, tuple[int, Callable[..., Node]]] | None = None,
) -> Node:
    """An expression from text such as "1 - alpha**2 * p / q".

    Args:
        text: +, -, *, /, ** with a constant exponent, parentheses, numbers, names, and sqrt, exp, exp2, log,
            abs, min, max, saturate (to [0, 1]).
        names: names of the inputs.
        lets: (name, text) pairs defined one after the other before `text`.
        functions: further functions by name: (number of arguments, builder of the expression).

    Raises `EcfitError` for anything else; nothing is executed.
    """
    calls = {**_FUNCTIONS, **(functions or {})}
    known: dict[str, Node] = {name: var(name) for name in names}
    for name, definition in lets:
        if name in known or not name.isidentifier():
            raise EcfitError(f"formula: '{name}' cannot be defined (again)")
        known[name] = _parsed(definition, known, calls)
    return _parsed(text, known, calls)


_Calls = Mapping[str, tuple[int, Callable[..., Node]]]


def _parsed(text: str, known: Mapping[str, Node], calls: _Calls) -> Node:
    if not isinstance(text, str) or len(text) > _LONGEST:
        raise EcfitError(f"formula: expected text of at most {_LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return _build(tree.body, known, calls)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        shown = text if len(text) < 80 else text[:77] + "..."
        raise EcfitError(f"formula: cannot read '{shown}'") from None


def _build(tree: ast.expr, known: Mapping[str, Node], calls: _Calls) -> Node:
    if isinstance(tree, ast.Constant) and type(tree.value) in (int, float):
        return const(float(tree.value))  # type: ignore[arg-type]
    if isinstance(tree, ast.Name):
        if tree.id not in known:
            raise EcfitError(f"formula: unknown name '{tree.id}'{did_you_mean(tree.id, list(known))}")
        return known[tree.id]
    if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub | ast.UAdd):
        inner = _build(tree.operand, known, calls)
        return -inner if isinstance(tree.op, ast.USub) else inner
    if isinstance(tree, ast.BinOp):
        left, right = _build(tree.left, known, calls), _build(tree.right, known, calls)
        if isinstance(tree.op, ast.Add):
            return left + right
        if isinstance(tree.op, ast.Sub):
            return left - right
        if isinstance(tree.op, ast.Mult):
            return left * right
        if isinstance(tree.op, ast.Div):
            return left / right
        if isinstance(tree.op, ast.Pow):
            if right.op != "const":
                raise EcfitError("formula: an exponent must be a number; write exp2(y * log(x)) otherwise")
            return power(left, right.value)
    if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.keywords:
        name, args = tree.func.id, [_build(a, known, calls) for a in tree.args]
        count, build = calls.get(name, (0, None))
        if build is None:
            raise EcfitError(f"formula: no function '{name}': expected one of {', '.join(calls)}")
        if len(args) != count:
            raise EcfitError(f"formula: {name} takes {count} arguments, got {len(args)}")
        return build(*args)
    raise EcfitError(f"formula: {type(tree).__name__} is not allowed")
