"""Values of expressions on arrays: NumPy of any float type, or JAX."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.expressions.node import Node, topological

Array = Any
# op -> function of the arguments; `pow` also takes its exponent.
Rules = Mapping[str, Callable[..., Any]]


def _rules(xp: Any) -> dict[str, Callable[..., Any]]:
    return {
        "neg": lambda x: -x,
        "sqrt": xp.sqrt,
        "exp": xp.exp,
        "exp2": xp.exp2,
        "log": xp.log,
        "abs": xp.abs,
        "pow": lambda x, exponent: x**exponent,
        "add": lambda x, y: x + y,
        "sub": lambda x, y: x - y,
        "mul": lambda x, y: x * y,
        "div": lambda x, y: x / y,
        "min": xp.minimum,
        "max": xp.maximum,
        "step": lambda x, edge: xp.heaviside(x - edge, 1.0),
    }


NUMPY, JAX = _rules(np), _rules(jnp)


def evaluate(
    roots: Sequence[Node], inputs: Mapping[str, Any], rules: Rules, constant: Callable[[float], Any]
) -> list[Any]:
    """Values of several expressions that share their subexpressions, under any arithmetic.

    Args:
        roots: what to evaluate.
        inputs: values by name.
        rules: a function for each operation.
        constant: turns a number into a value.
    """
    order = topological(roots)
    uses: dict[int, int] = {}
    for node in order:
        for argument in node.args:
            uses[id(argument)] = uses.get(id(argument), 0) + 1
    for root in roots:
        uses[id(root)] = uses.get(id(root), 0) + 1
    values: dict[int, Any] = {}
    for node in order:
        if node.op == "const":
            result = constant(node.value)
        elif node.op == "var":
            result = inputs[node.name]
        else:
            arguments = [values[id(a)] for a in node.args]
            if node.op == "pow":
                arguments.append(node.value)
            result = rules[node.op](*arguments)
        values[id(node)] = result
        for argument in node.args:  # freed as soon as nothing needs it: large arrays
            uses[id(argument)] -= 1
            if not uses[id(argument)]:
                del values[id(argument)]
    return [values[id(root)] for root in roots]


def value(root: Node, inputs: Mapping[str, Array]) -> Array:
    """The value at inputs that broadcast: JAX where an input is a JAX array, else NumPy.

    NumPy arithmetic runs in the inputs' own float type (float64, float32, float16), constants rounded to it.
    """
    if any(isinstance(a, jax.Array) for a in inputs.values()):
        return evaluate([root], inputs, JAX, lambda c: c)[0]
    kind = np.result_type(*inputs.values(), np.float16)
    with np.errstate(all="ignore"):
        return evaluate([root], inputs, NUMPY, lambda c: kind.type(c))[0]
