"""Which subexpressions get a name of their own, and which."""

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from fractions import Fraction

from ecfit.expressions import Node
from ecfit.expressions.node import topological

# No names of powers are made from these: t12 could be anything.
_NUMBERED = re.compile(r".*\d")
# A numerator or denominator of so many operations is read more easily with a name.
_LONG = 4
# The same for a subexpression whose meaning is known.
_MEANT = 2


def named(
    roots: Sequence[Node], meanings: Mapping[Node, str], taken: Iterable[str], repeats: Iterable[str] = ()
) -> dict[Node, str]:
    """Names of local constants, in the order in which they must be defined.

    Named is what is used more than once, what has a meaning, and long numerators and denominators.

    Args:
        roots: the expressions.
        meanings: what some subexpressions are, as a name.
        taken: names that are not available.
        repeats: operations that the language writes with an argument twice, which must then be short.
    """
    order = topological(roots)
    uses = Counter(id(a) for node in order for a in node.args)
    repeated = {id(a) for node in order if node.op in repeats for a in node.args}
    used, out = set(taken), {}
    meanings = {node: name for node, name in meanings.items() if name not in used}
    sizes = _sizes(order, {node for node in order if uses[id(node)] > 1 or node in meanings})
    ratios = _ratios(order, sizes)
    powers = _powers(order, meanings)
    final = {id(r) for r in roots}
    for node in order:
        if not node.args or id(node) in final or node.op == "neg":
            continue
        meant = meanings.get(node, "") if sizes[node] >= _MEANT else ""
        if uses[id(node)] > 1 or id(node) in repeated or node in ratios or meant:
            out[node] = _unused(_stem(node, meanings, ratios, powers, out), used)
    return out


def _stem(
    node: Node,
    meanings: Mapping[Node, str],
    ratios: Mapping[Node, str],
    powers: Mapping[Node, tuple[Node, Fraction]],
    names: Mapping[Node, str],
) -> str:
    if node in meanings:
        return meanings[node]
    if node in powers:
        base, exponent = powers[node]
        stem = base.name if base.op == "var" else names.get(base, "")
        if stem and not _NUMBERED.fullmatch(stem):
            return _power_name(stem, exponent)
    limited = _limited_input(node)
    return f"{limited}_safe" if limited else ratios.get(node, "t1")


def _limited_input(node: Node) -> str:
    """The input that limits (minima and maxima with numbers) are put on, or nothing."""
    while node.op in ("min", "max") and node.args[1].op == "const":
        node = node.args[0]
        if node.op == "var":
            return node.name
    return ""


def _power_name(stem: str, exponent: Fraction) -> str:
    """mu2, mu_3_2 (to the power 3/2), sqrt_mu."""
    if exponent == Fraction(1, 2):
        return f"sqrt_{stem}"
    if exponent.denominator == 1:
        return f"{stem}{exponent}"
    return f"{stem}_{exponent.numerator}_{exponent.denominator}"


def _unused(stem: str, used: set[str]) -> str:
    """The stem, or the stem with the first number from 2 that is free."""
    name, base = stem, stem.rstrip("0123456789") if stem == "t1" else f"{stem}_"
    number = 2
    while name in used:
        name, number = f"{base}{number}", number + 1
    used.add(name)
    return name


def _sizes(order: Sequence[Node], apart: Collection[Node]) -> dict[Node, int]:
    """Operations of each node that stand in its own text: those under nodes `apart` do not."""
    out: dict[Node, int] = {}
    for node in order:
        out[node] = bool(node.args) + sum(0 if a in apart else out[a] for a in node.args)
    return out


def _ratios(order: Sequence[Node], sizes: Mapping[Node, int]) -> dict[Node, str]:
    """Long numerators and denominators: p and q, numbered where there are several."""
    found: dict[str, list[Node]] = {"p": [], "q": []}
    for node in order:
        if node.op == "div":
            for letter, part in zip("pq", node.args, strict=True):
                if sizes[part] >= _LONG and part not in found[letter]:
                    found[letter].append(part)
    return {
        node: letter if len(nodes) == 1 else f"{letter}{i + 1}"
        for letter, nodes in found.items()
        for i, node in enumerate(nodes)
    }


def _powers(order: Sequence[Node], meanings: Mapping[Node, str]) -> dict[Node, tuple[Node, Fraction]]:
    """Base and exponent of what is a power of another expression, multiples of 1/4; a meaning is a base."""
    out: dict[Node, tuple[Node, Fraction]] = {}
    for node in order:
        if node in meanings:
            continue
        if node.op == "sqrt":
            base, exponent = out.get(node.args[0], (node.args[0], Fraction(1)))
            if exponent.denominator <= 2:
                out[node] = base, exponent / 2
        elif node.op == "mul":
            (x, i), (y, j) = (out.get(a, (a, Fraction(1))) for a in node.args)
            if x is y:
                out[node] = x, i + j
    return out
