"""Heads: how an albedo is put together from ratios P / Q of sparse polynomials that share one denominator.

A head is data: what the ratios are multiplied by (`factors`, powers of features), and a formula of those
products X (one ratio) or X1, X2, ... It is also the one place that knows a form's exact limits: 1 - E is
a non-negative product times a `deficit`, and E, where it may touch 0, one times a `surplus`, whose signs are
held in fits and then proved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from ecfit.errors import EcfitError, unknown
from ecfit.expressions import Node, const, maximum, minimum, parse, power, sqrt, substitute, var
from ecfit.expressions.node import inputs
from ecfit.forms.features import FEATURES, FUJII, check_powers, monomial, order, plain, scaled

_SQRT_F0 = sqrt(var("F0"))


def exact_fresnel(x: Node) -> Node:
    """Fresnel of a dielectric from outside at the cosine x, in terms of F0 (Walter et al. 2007, eq. 22)."""
    e = (1.0 - _SQRT_F0) / (1.0 + _SQRT_F0)
    # 0 / 0 only for x = 0, at F0 = 0 and 1: 1e-15 is far below any cosine, its square within float32.
    x = maximum(x, 1e-15)
    rest = (1.0 - e) * (1.0 + e)
    c = sqrt(rest + (e * x) * (e * x))
    s = rest / (e * x + c)
    s = s / (e * x + c)
    p = (x - e * c) / (x + e * c)
    return minimum(0.5 * (s * s + p * p), 1.0)


def schlick_fresnel(x: Node) -> Node:
    """F0 + (1 - F0) (1 - x)^5 (Schlick 1994)."""
    return var("F0") + (1.0 - var("F0")) * power(1.0 - x, 5)


FRESNELS = {"exact": exact_fresnel, "schlick": schlick_fresnel}


class Held(NamedTuple):
    """What a fit holds >= 0: `end` - value, or value - `end`, is `shared` x `rest`.

    Attributes:
        name: "deficit" (1 - value) or "surplus" (value).
        shared: powers of features, where alpha and mu stand for t and m of the corner chart.
        rest: formula in X / shared, written X again.
    """

    name: str
    shared: Mapping[str, float]
    rest: Node


@dataclass(frozen=True, eq=False)
class Head:
    """A formula over ratios.

    Attributes:
        name: how configs call it.
        factors: for each ratio, the powers of features that multiply it: X_i = factor_i P_i / Q.
        text: the value, in X (or X1, X2, ...), features, and `fresnel(c)`, the factor F(c, F0).
        lets: (name, text) pairs before `text`.
        shared: powers of features taken out of the deficit: 1 - value = shared x deficit, where alpha and mu
            stand for t and m of the corner chart.
        deficit: formula in X / shared, written X again; empty where the value is not bounded by 1.
        floor, surplus: the same for the lower end: value = floor x surplus; empty where the value stays away
            from 0 by itself.
        limits: exact values at limits, in words.
        fresnel: name of `FRESNELS`.

    Raises `EcfitError` for a text that cannot be read, no factor, and unknown names of features and
    Fresnel factors.
    """

    name: str
    factors: tuple[Mapping[str, float], ...]
    text: str
    lets: tuple[tuple[str, str], ...] = ()
    shared: Mapping[str, float] = field(default_factory=dict)
    deficit: str = ""
    floor: Mapping[str, float] = field(default_factory=dict)
    surplus: str = ""
    limits: str = ""
    fresnel: str = "exact"

    def __post_init__(self) -> None:
        where = f"head '{self.name}'"
        if not self.factors:
            raise EcfitError(f"{where}: needs at least one factor")
        object.__setattr__(self, "factors", tuple(check_powers(f, where) for f in self.factors))
        object.__setattr__(self, "shared", check_powers(self.shared, where))
        object.__setattr__(self, "floor", check_powers(self.floor, where))
        if self.fresnel not in FRESNELS:
            raise unknown("Fresnel factor", self.fresnel, FRESNELS)
        _ = self.value, self.held  # parsed here, so that a wrong formula fails at once

    @property
    def ratios(self) -> int:
        """Number of ratios P / Q that the text speaks of."""
        return len(self.factors)

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the products X in the formulas."""
        return ("X",) if self.ratios == 1 else tuple(f"X{i + 1}" for i in range(self.ratios))

    def _parse(self, text: str) -> Node:
        known = {"fresnel": (1, FRESNELS[self.fresnel])}
        try:
            return parse(text, (*self.symbols, *FEATURES), self.lets, known)
        except EcfitError as error:
            raise EcfitError(f"head '{self.name}': {error}") from None

    @cached_property
    def value(self) -> Node:
        """The value in terms of the X and of features by name."""
        return self._parse(self.text)

    @cached_property
    def held(self) -> tuple[Held, ...]:
        """The limits, in terms of X / shared and of features by name."""
        ends = (("deficit", self.shared, self.deficit), ("surplus", self.floor, self.surplus))
        return tuple(Held(name, shared, self._parse(text)) for name, shared, text in ends if text)

    @cached_property
    def _used(self) -> set[str]:
        return set().union(inputs(self.value), *(inputs(h.rest) for h in self.held))

    @cached_property
    def features(self) -> tuple[str, ...]:
        """Features that the formulas and factors use."""
        used = set(self._used)
        for factor in self.factors:
            used |= set(factor)
        return tuple(name for name in FEATURES if name in used)

    def expression(self, ratios: Sequence[Node]) -> Node:
        """The value as an expression of the coordinates, given the ratios P_i / Q."""
        return self._put(self.value, ratios)

    def definitions(self, ratios: Sequence[Node]) -> dict[str, Node]:
        """What `lets` define, as parts of `expression`."""
        return {name: self._put(self._parse(name), ratios) for name, _ in self.lets}

    def _put(self, formula: Node, ratios: Sequence[Node]) -> Node:
        nodes = {name: plain(name) for name in FEATURES}
        x = [monomial(f, nodes) * ratio for f, ratio in zip(self.factors, ratios, strict=True)]
        return substitute(formula, {**nodes, **dict(zip(self.symbols, x, strict=True))})

    def orders(self, ratios: Sequence[float]) -> tuple[float, ...]:
        """Order of each X at the corner, given those of the ratios. Raises `EcfitError` for one below 0."""
        out = tuple(order(f) + o for f, o in zip(self.factors, ratios, strict=True))
        if min(out) < -1e-9:
            raise EcfitError(f"head '{self.name}': P / Q outgrows its factor at alpha = mu = 0")
        return out

    def in_chart(self, ratios: Sequence[Node], orders: Sequence[float]) -> tuple[Node, tuple[Node, ...]]:
        """Value and `held` in the corner chart, given the P_i / Q divided by rho^order, and orders."""
        full = dict(zip(self.inputs, self.chart_inputs(), strict=True))

        def put(formula: Node, shared: Mapping[str, float]) -> Node:
            rows = zip(self.symbols, self.chart_factors(orders, shared), ratios, strict=True)
            return substitute(formula, {**full, **{symbol: f * ratio for symbol, f, ratio in rows}})

        return put(self.value, {}), tuple(put(h.rest, h.shared) for h in self.held)

    def chart_factors(self, orders: Sequence[float], shared: Mapping[str, float]) -> list[Node]:
        """What multiplies each P_i' / Q' in the chart, without what is `shared`."""
        nodes = {name: scaled(name) for name in FEATURES}
        out = []
        for factor, net in zip(self.factors, self.orders(orders), strict=True):
            rest = {n: e - shared.get(n, 0.0) for n, e in factor.items()}
            out.append(monomial(rest, nodes) * rho_power(net))
        return out

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Names of the features in the formulas, in a fixed order."""
        return tuple(sorted(self._used - set(self.symbols)))

    def chart_inputs(self) -> list[Node]:
        """The features of `inputs` in the chart."""
        return [scaled(name) * rho_power(FEATURES[name].order) for name in self.inputs]


def rho_power(exponent: float) -> Node:
    """rho^exponent, 1 for 0."""
    return power(var("rho"), exponent) if exponent > 1e-9 else const(1.0)


_ONE = {"alpha": 2.0}

HEADS: dict[str, Head] = {
    h.name: h
    for h in (
        Head("ratio", ({},), "X", limits="none"),
        Head("corner", (_ONE,), "1 - X", (), _ONE, "X", limits="E = 1 at alpha = 0"),
        Head("corner-product", ({"alpha": 2.0, "mu": 1.0},), "1 - X", (), {"alpha": 2.0, "mu": 1.0}, "X",
             limits="E = 1 at alpha = 0 and at mu = 0"),
        Head("masking", ({"alpha": 2.0, "s": 1.0},), "G1 + X", (), _ONE, "T - X",
             limits="E = 1 at alpha = 0, E = G1 at F0 = 0"),
        # Straight through an interface of equal indices: G2 / G1 = (1 + L) / (1 + 2 L), L = Lambda(wo).
        Head("masking-correlated", ({"alpha": 2.0, "s": 1.0},), "1/(2 - G1) + X", (), _ONE, "T/(2 - G1) - X",
             limits="E = 1 at alpha = 0, E = 1 / (2 - G1) at F0 = 0"),
        Head("masking-root", ({"alpha": 2.0, "v": 1.0},), "G1 + X", (), _ONE, "T - X",
             limits="E = 1 at alpha = 0, E = G1 at F0 = 0"),
        Head("schlick-b", ({"alpha": 2.0, "u": 1.0},), "u**5 - X", (), {}, "1 - u**5 + X", {"u": 1.0},
             "u**4 - X", limits="B = (1 - mu)^5 at alpha = 0, 0 at mu = 1"),
        # Where B touches 1, at alpha = mu = 0, a form of separable masking is not proved to stay below it.
        Head("schlick-b-capped", ({"alpha": 2.0, "u": 1.0},), "min(u**5 - X, 1)", (), {}, "", {"u": 1.0},
             "u**4 - X", limits="B = (1 - mu)^5 at alpha = 0, 0 at mu = 1, at most 1"),
        Head("schlick-f82", ({"alpha": 2.0},), "mu*u**6 + X", surplus="mu*u**6 + X",
             limits="mu (1 - mu)^6 at alpha = 0"),
        Head("two-point", ({"alpha": 1.0}, {"alpha": 1.0}, {}), "a*F1 + (1 - a)*F2",
             (("F1", "fresnel(saturate(mu + X1))"), ("F2", "fresnel(saturate(mu + X2))"),
              ("a", "saturate(X3)")),
             {}, "a*(1 - F1) + (1 - a)*(1 - F2)", limits="E = F(mu) at alpha = 0, 0 at F0 = 0, 1 at F0 = 1"),
        Head("inside", ({"alpha": 1.0},), "min(max(F_in + X, 0), 1)",
             limits="E = F(mu) from inside at alpha = 0, in [0, 1]"),
        Head("average", ({"r": 4.0},), "1 - X", (), {}, "X", limits="E_avg = 1 at alpha = 0"),
        # 1 - E of Fujii's Oren-Nayar is 0 at mu = 0 and B_F (1/2 - 2/(3 pi)) at mu = 1; the printed
        # polynomial has the second only.
        Head("fujii", ({"B_F": 1.0, "mu": 1.0, "u": 1.0},), f"1 - {FUJII}*B_F*mu - X", (),
             {"B_F": 1.0}, f"{FUJII}*mu + X",
             limits="E = 1 at mu = 0 and without roughness, A_F at mu = 1"),
        Head("qualitative", ({"B_q": 1.0},), "A_q + X", limits="E = 1 without roughness"),
        Head("times-x", ({"x": 1.0},), "X", limits="0 at ior = 1"),
    )
}  # fmt: skip


def head(name: str) -> Head:
    """A head by name. Raises `EcfitError` for an unknown one (it lists the known)."""
    if name not in HEADS:
        raise unknown("head", name, HEADS)
    return HEADS[name]
