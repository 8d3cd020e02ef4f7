"""C text of approximations: a loop over points, from an expression or for a table.

Compiled as it is it computes in float; with -DREAL=double, in double, to see that the text is right.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from ecfit.expressions import Node
from ecfit.expressions.node import topological

# How an operation reads in C. Comparisons as below become one instruction each.
_OPERATORS = {"add": "({} + {})", "sub": "({} - {})", "mul": "({} * {})", "div": "({} / {})", "neg": "(-{})"}
_CALLS = {"sqrt": "sqrt", "exp": "exp", "exp2": "exp2", "log": "log", "abs": "fabs"}
_COMPARISONS = {"min": "<", "max": ">"}

HEADER = """\
#include <tgmath.h>
#ifdef REAL
#define NUMBER(x) x
#else
#define REAL float
#define NUMBER(x) x##f
#endif
/* Between two passes: nothing of the last one may be left out. */
#define AGAIN __asm__ volatile("" ::: "memory")
"""


def literal(value: float) -> str:
    """A number as a constant."""
    return f"(-NUMBER({-value!r}))" if value < 0.0 else f"NUMBER({value!r})"


def body(root: Node) -> tuple[list[str], str]:
    """Definitions of what is used more than once, and the value in terms of them.

    Powers need no case of their own: the expressions have them as products and square roots already, unless
    the exponent is no multiple of 1/4.
    """
    order = topological([root])
    uses = Counter(id(argument) for node in order for argument in node.args)
    text: dict[int, str] = {}
    lines: list[str] = []
    for node in order:
        arguments = [text[id(a)] for a in node.args]
        if node.op == "const":
            found = literal(node.value)
        elif node.op == "var":
            found = node.name
        elif node.op in _OPERATORS:
            found = _OPERATORS[node.op].format(*arguments)
        elif node.op in _CALLS:
            found = f"{_CALLS[node.op]}({arguments[0]})"
        elif node.op == "pow":
            found = f"pow({arguments[0]}, {literal(node.value)})"
        else:
            # The arguments appear twice: they are named first, unless they are names already.
            for i, argument in enumerate(node.args):
                if argument.args and not arguments[i].isidentifier():
                    lines.append(f"const REAL v{len(lines)} = {arguments[i]};")
                    arguments[i] = text[id(argument)] = f"v{len(lines) - 1}"
            x, y = arguments
            found = f"({x} {_COMPARISONS[node.op]} {y} ? {x} : {y})"
        if node.args and uses[id(node)] > 1:
            lines.append(f"const REAL v{len(lines)} = {found};")
            found = f"v{len(lines) - 1}"
        text[id(node)] = found
    return lines, text[id(root)]


def kernel(
    name: str, variables: Sequence[str], lines: Sequence[str], value: str, constants: Sequence[str] = ()
) -> str:
    """`void name(const REAL *const *in, REAL *out, int points, int passes)`: many passes over the points.

    `in` has an array for each variable, then one for each of `constants`, arrays that are the same for all
    points.
    """
    arrays = [*(f"in_{v}" for v in variables), *constants]
    # Only as parameters of a function are restricted pointers sure to be seen as such.
    parameters = ", ".join(f"const REAL *restrict {a}" for a in arrays)
    inputs = [f"const REAL {v} = in_{v}[k];" for v in variables]
    inner = "\n".join(f"    {line}" for line in (*inputs, *lines))
    passed = ", ".join(f"in[{i}]" for i in range(len(arrays)))
    return f"""
static __attribute__((noinline)) void {name}_once({parameters}, REAL *restrict out, int points) {{
  for (int k = 0; k < points; ++k) {{
{inner}
    out[k] = {value};
  }}
}}
void {name}(const REAL *const *in, REAL *out, int points, int passes) {{
  for (int i = 0; i < passes; ++i) {{ {name}_once({passed}, out, points); AGAIN; }}
}}
"""


def of_expression(name: str, root: Node, variables: Sequence[str]) -> str:
    """A kernel that evaluates an expression of `variables`."""
    return kernel(name, variables, *body(root))


def of_table(name: str, shape: Sequence[int], roots: Sequence[int]) -> str:
    """A kernel that reads a table on [0, 1]^n linearly; the table is the last input, in row-major order.

    `roots` says how often the root of each coordinate is taken to get what the nodes are uniform in. As a
    texture is sampled, nothing is clamped but the last cell.
    """
    variables = [f"x{i}" for i in range(len(shape))]
    lines = []
    for i, count in enumerate(shape):
        lines += [
            f"const REAL s{i} = {'sqrt(' * roots[i]}x{i}{')' * roots[i]} * {count - 1};",
            f"const int f{i} = (int)s{i}, c{i} = f{i} < {count - 2} ? f{i} : {count - 2};",
            f"const REAL t{i} = s{i} - (REAL)c{i};",
        ]
    flat = "c0"
    for i, count in enumerate(shape[1:], 1):
        flat = f"({flat} * {count} + c{i})"
    lines.append(f"const int at = {flat};")
    strides = [int(np.prod(shape[i + 1 :])) for i in range(len(shape))]
    # Corners along the last axis first, then pairs of them along the one before.
    corners = np.ndindex(*[2] * len(shape))
    level = [f"table[at + {sum(s * b for s, b in zip(strides, bits, strict=True))}]" for bits in corners]
    count = 0
    for i in reversed(range(len(shape))):
        pairs, level = list(zip(level[::2], level[1::2], strict=True)), []
        for a, b in pairs:
            lines.append(f"const REAL a{count} = {a}, l{count} = a{count} + t{i} * ({b} - a{count});")
            level.append(f"l{count}")
            count += 1
    return kernel(name, variables, lines, level[0], ["table"])
