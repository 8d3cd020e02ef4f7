"""What is proved about an approximation: its expression, and the box over which bounds are taken.

Forms in alpha and mu are proved in the corner chart (alpha = rho t, mu = rho (1 - t)), which covers the
closed domain and in which nothing is 0 / 0. Such a form is evaluated with a cosine of at least its
`least_mu`, so its values at lower cosines are among those bounded.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from ecfit.approximation import Approximation
from ecfit.approximation.composed import Composed
from ecfit.approximation.formula import Formula
from ecfit.approximation.structured import StructuredFormula
from ecfit.expressions import Node, maximum, minimum, substitute
from ecfit.expressions.bounds import smallest
from ecfit.expressions.node import inputs, replaced, topological
from ecfit.forms import Minimum
from ecfit.forms.corner import ChartDomain
from ecfit.forms.features import FEATURES, chart, monomial, scaled
from ecfit.forms.structured import LEAST_MU

Box = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Subject:
    """An expression over a closed domain.

    Attributes:
        value: the value, in the variables of `domain.box`; alpha and mu are clipped to their ranges, as boxes
            of the chart reach beyond the domain.
        chart: the same without that.
        plain: the expression as it is evaluated, in the approximation's variables.
        divisors: (what it is called, the expression in `box`, the same in the approximation's variables or
            None) of every division in `value`; the form's own denominator first.
        held: "deficit" -> (shared, rest): 1 - value = shared x rest; "surplus" -> the same for the value;
            those that the form has.
        domain: the closed domain.
        charted: whether `value` is in the corner chart.
        parts: of a composed formula, the subjects of its parts by name; `text` is the value in their names.
        floors: what has been proved of divisors; see `ecfit.expressions.bounds.smallest`.
        least_mu: what `plain` raises cosines to, if it does.
    """

    value: Node
    chart: Node
    plain: Node
    divisors: tuple[tuple[str, Node, Node | None], ...]
    domain: ChartDomain
    charted: bool
    held: Mapping[str, tuple[Node, Node]] = field(default_factory=dict)
    parts: Mapping[str, "Subject"] = field(default_factory=dict)
    text: Node | None = None
    floors: Mapping[Node, float] = field(default_factory=dict)
    least_mu: float = LEAST_MU

    @classmethod
    def of(cls, approximation: Approximation) -> "Subject":
        """The subject of an approximation. Raises `EcfitError` for tables, which have no expression."""
        ranges = dict(zip(approximation.variables, approximation.domain, strict=True))
        return cls._of(approximation.formula, approximation.expression(), ranges, approximation.is_quotient)

    @classmethod
    def _of(cls, formula: Formula, plain: Node, ranges: Box, quotient: bool) -> "Subject":
        if isinstance(formula, StructuredFormula):
            return cls._structured(formula, plain, ranges)
        if isinstance(formula, Composed):
            return cls._composed(formula, plain, ranges)
        named = [("Q", q) for q in _divisors(plain)[:1]] if quotient else []
        rest = [q for q in _divisors(plain) if q not in [n for _, n in named]]
        divisors = [*named, *((f"divisor {i + 1}", q) for i, q in enumerate(rest))]
        domain = ChartDomain(ranges, ranges)
        return cls(plain, plain, plain, tuple((name, q, q) for name, q in divisors), domain, False)

    @classmethod
    def _structured(cls, formula: StructuredFormula, plain: Node, ranges: Box) -> "Subject":
        structure = formula.structure
        value, held, q = structure.chart(formula.values)
        own = structure.divisor(formula.values)
        domain = ChartDomain.of(ranges)
        clipped = _clipped(ranges)
        value_, q_ = replaced(value, clipped), replaced(q, clipped)
        divisors = [("Q'" if structure.corner else "Q", q_, own)] if q.op != "const" else []
        rest = [n for n in _divisors(value_) if n is not q_]
        divisors += [(f"divisor {i + 1}", n, None) for i, n in enumerate(rest)]
        features = {name: scaled(name) for name in FEATURES}
        products = {
            h.name: (replaced(monomial(h.shared, features), clipped), replaced(rest, clipped))
            for h, rest in zip(structure.head.held, held, strict=True)
        }
        charted = bool({"t", "rho"} & inputs(value))
        least_mu = structure.least_mu
        return cls(value_, value, plain, tuple(divisors), domain, charted, products, least_mu=least_mu)

    @classmethod
    def _composed(cls, formula: Composed, plain: Node, ranges: Box) -> "Subject":
        parts = {
            p.name: cls._of(
                p.formula, p.formula.expression(p.variables), {v: ranges[v] for v in p.variables}, False
            )
            for p in formula.parts
        }
        charted = any(part.charted for part in parts.values())
        if charted:
            parts = {name: part.in_chart() for name, part in parts.items()}
        text = formula.text_expression
        value = substitute(text, {name: part.value for name, part in parts.items()})
        divisors = [
            (f"{name}: {label}", node, own)
            for name, part in parts.items()
            for label, node, own in part.divisors
        ]
        known = [node for _, node, _ in divisors]
        rest = [node for node in _divisors(value) if node not in known]
        divisors += [(f"divisor {i + 1}", node, None) for i, node in enumerate(rest)]
        return cls(
            value,
            substitute(text, {name: part.chart for name, part in parts.items()}),
            plain,
            tuple(divisors),
            ChartDomain.of(ranges) if charted else ChartDomain(ranges, ranges),
            charted,
            parts=parts,
            text=text,
        )

    def in_chart(self) -> "Subject":
        """The same with alpha and mu written in the corner chart, where they were not."""
        if self.charted or not {"alpha", "mu"} & set(self.domain.ranges):
            return self
        nodes = chart()
        return replace(
            self,
            value=replaced(substitute(self.value, nodes), _clipped(self.domain.ranges)),
            chart=substitute(self.chart, nodes),
            divisors=tuple((name, substitute(node, nodes), own) for name, node, own in self.divisors),
            domain=ChartDomain.of(self.domain.ranges),
            charted=True,
        )

    def knowing(self, floors: Mapping[Node, float]) -> "Subject":
        """The same, with what has been proved of divisors."""
        parts = {name: part.knowing(floors) for name, part in self.parts.items()}
        return replace(self, floors=floors, parts=parts)

    @cached_property
    def roots(self) -> tuple[Node, ...]:
        """Arguments of square roots and of powers that are not whole, all to be >= 0."""
        found = {
            n.args[0]: None
            for n in topological([self.value])
            if n.op == "sqrt" or (n.op == "pow" and n.value != int(n.value))
        }
        return tuple(n for n in found if n.op not in ("var", "const"))

    @cached_property
    def logarithms(self) -> tuple[Node, ...]:
        """Arguments of logarithms, all to be > 0."""
        return tuple({n.args[0]: None for n in topological([self.value]) if n.op == "log"})

    def smallest(
        self, node: Node, enough: float | None = None, tolerance: float = 1e-3, limit: int = 200_000
    ) -> Minimum:
        """The minimum of an expression in the variables of `domain.box` over the closed domain."""
        if self.charted:
            return self.domain.smallest(
                node, enough=enough, tolerance=tolerance, limit=limit, floors=self.floors
            )
        return smallest(
            node, self.domain.box, enough=enough, tolerance=tolerance, limit=limit, floors=self.floors
        )

    def place(self, point: tuple[float, ...]) -> dict[str, float]:
        """The approximation's coordinates at a point of the box."""
        return self.domain.place(dict(zip(self.domain.box, point, strict=True)))


def _clipped(ranges: Box) -> dict[Node, Node]:
    """alpha and mu of the chart -> the same within their ranges."""
    if not {"alpha", "mu"} <= set(ranges):
        return {}
    return {node: minimum(maximum(node, ranges[name][0]), ranges[name][1]) for name, node in chart().items()}


def _divisors(root: Node) -> list[Node]:
    found = {n.args[1]: None for n in topological([root]) if n.op == "div" and n.args[1].op != "const"}
    return list(found)
