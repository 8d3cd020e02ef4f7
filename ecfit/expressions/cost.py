"""What an expression costs: operations counted, each distinct subexpression once."""

from typing import NamedTuple

from ecfit.expressions.node import Node, topological

# Relative costs of one operation on a GPU, in multiply-adds: divisions, roots and transcendentals run at a
# quarter of the rate (special-function units), a division being a reciprocal and a product.
_WEIGHTS = {"divisions": 5.0, "roots": 4.0, "transcendentals": 4.0}


class Cost(NamedTuple):
    """Numbers of operations. `adds` and `products` fuse in pairs into multiply-adds."""

    products: int
    adds: int
    divisions: int
    roots: int
    transcendentals: int
    comparisons: int

    @property
    def multiply_adds(self) -> int:
        """Products and sums, fused where one of each is at hand."""
        return max(self.products, self.adds)

    @property
    def total(self) -> float:
        """In units of a multiply-add."""
        slow = sum(weight * getattr(self, name) for name, weight in _WEIGHTS.items())
        return self.multiply_adds + self.comparisons + slow

    def __str__(self) -> str:
        parts = [f"{self.multiply_adds} multiply-adds"]
        for name in ("divisions", "roots", "transcendentals", "comparisons"):
            count = getattr(self, name)
            if count:
                parts.append(f"{count} {name if count > 1 else name[:-1]}")
        return ", ".join(parts)


_KIND = {
    "mul": "products", "add": "adds", "sub": "adds", "div": "divisions", "sqrt": "roots",
    "exp": "transcendentals", "exp2": "transcendentals", "log": "transcendentals", "pow": "transcendentals",
    "min": "comparisons", "max": "comparisons", "step": "comparisons",
}  # fmt: skip


def cost(root: Node) -> Cost:
    """Operations of an expression; signs and absolute values are free."""
    counts = dict.fromkeys(Cost._fields, 0)
    for node in topological([root]):
        if node.op in _KIND:
            counts[_KIND[node.op]] += 1
    return Cost(**counts)
