"""Expressions of the corner chart in roots of its coordinates, where half powers have bounded slopes.

With alpha or mu to a half power a form's slope is infinite at t = 0, m = 0 or rho = 0, and interval bounds
by first derivatives fail there. In x = sqrt(t) and y = sqrt(rho) such a form is a polynomial again. t and
m = 1 - t cannot both be squares, so the chart is covered by two pieces: t <= 1/2 with t = x^2, and m <= 1/2
with m = x^2. F0, of which features take fourth roots, is x^4 where an expression has a root of it; elsewhere
it stays as it is, as 1 - x^4 is not exactly >= 0 when rounded outward.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ecfit.expressions import Node, var
from ecfit.expressions.node import topological, with_roots

Range = tuple[float, float]

_T, _M = var("t"), 1.0 - var("t")
# Of the roots' names: no coordinate has it.
_PREFIX = "root_"


@dataclass(frozen=True)
class Piece:
    """A part of the chart's box.

    Attributes:
        box: closed ranges of the piece's variables, in the order of the chart's.
        mirrored: whether t's variable is sqrt(m) = sqrt(1 - t) instead of sqrt(t).
    """

    box: Mapping[str, Range]
    mirrored: bool

    def rooted(self, node: Node) -> Node:
        """An expression of t, rho and other coordinates in the piece's variables."""
        put: dict[Node, Node] = {}
        for name in self.box:
            root = var(name)
            if name == _PREFIX + "t":
                square = root * root
                put |= {_T: 1.0 - square, _M: square} if self.mirrored else {_T: square, _M: 1.0 - square}
            elif name == _PREFIX + "rho":
                put[var("rho")] = root * root
            elif name == _PREFIX + "F0":
                put[var("F0")] = (root * root) * (root * root)
        return with_roots(node, put)

    def chart(self, at: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The chart's coordinates of points given in the piece's variables; rounded to nearest."""
        out = {}
        for name, x in at.items():
            if name == _PREFIX + "t":
                out["t"] = 1.0 - x * x if self.mirrored else x * x
            elif name == _PREFIX + "rho":
                out["rho"] = x * x
            elif name == _PREFIX + "F0":
                out["F0"] = (x * x) * (x * x)
            else:
                out[name] = x
        return out


def pieces(box: Mapping[str, Range], node: Node) -> list[Piece]:
    """The pieces that cover a box of the chart, for an expression."""
    orders = {"t": 2, "rho": 2}
    if any(n.op == "sqrt" and n.args[0] is var("F0") for n in topological([node])):
        orders["F0"] = 4
    if "t" not in box:
        return [Piece(_roots(box, orders), False)]
    low, high = box["t"]
    out = []
    if low <= 0.5:
        out.append(Piece(_roots({**box, "t": (low, min(high, 0.5))}, orders), False))
    if high > 0.5:
        mirrored = max(1.0 - high, 0.0), min(1.0 - low, 0.5)
        out.append(Piece(_roots({**box, "t": mirrored}, orders), True))
    return out


def _roots(box: Mapping[str, Range], orders: Mapping[str, int]) -> dict[str, Range]:
    """Ranges of the roots, rounded outward; other coordinates as they are."""
    out = {}
    for name, (low, high) in box.items():
        if name in orders:
            out[_PREFIX + name] = _root(low, orders[name], -1), _root(high, orders[name], 1)
        else:
            out[name] = low, high
    return out


def _root(x: float, order: int, towards: int) -> float:
    """x^(1/order), at most (`towards` -1) or at least (1) the true one."""
    if x <= 0.0 or x == 1.0:
        return max(x, 0.0)
    # Roots of powers of two are often off by one unit; two are safe.
    root = float(np.sqrt(x) if order == 2 else np.sqrt(np.sqrt(x)))
    for _ in range(2):
        root = float(np.nextafter(root, towards * np.inf))
    return root
