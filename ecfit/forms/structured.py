"""Structured forms: a head over ratios of sparse polynomials in named features, one shared denominator."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ecfit.errors import EcfitError, unknown
from ecfit.expressions import Node, maximum, substitute, var
from ecfit.expressions.evaluate import NUMPY, evaluate
from ecfit.expressions.node import const
from ecfit.forms.features import (
    COORDINATES,
    FEATURES,
    coordinates_of,
    feature,
    monomial,
    plain,
    scaled,
    untied,
)
from ecfit.forms.heads import Head, head, rho_power
from ecfit.forms.nested import nested

# At alpha = mu = 0 the forms are 0 / 0; a cosine of at least this defines them there (E = 1 at alpha = 0).
# Half of its third power is far above the least float32.
LEAST_MU = 1e-6
# The same for forms made for half precision: its least normal number. What is below has fewer digits, and
# hardware may flush it to 0.
LEAST_HALF = 2.0**-14

# Features that are 0 / 0 there themselves.
_AT_CORNER = frozenset({"G1", "T"})

Exponents = np.ndarray


def _exponents(rows: Any, features: Sequence[str], where: str) -> np.ndarray:
    try:
        array = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty((0, 0))
    if array.ndim != 2 or array.shape[1] != len(features):
        raise EcfitError(
            f"{where}: exponents must be rows of {len(features)} numbers, for {', '.join(features)}"
        )
    if not np.all(np.isfinite(array)) or np.any(array < 0.0) or np.any(array > 64.0):
        raise EcfitError(f"{where}: exponents must be in 0..64")
    if len(np.unique(array, axis=0)) < len(array):
        raise EcfitError(f"{where}: an exponent row repeats")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Structure:
    """Which terms a structured form has: everything but its coefficients.

    Attributes:
        head: how the value is put together.
        features: names of the features whose powers the terms are.
        numerators: for each ratio of the head, exponents, shape (terms, features), multiples of 1/4.
        denominator: exponents of the shared Q, shape (terms, features); the first has the coefficient 1.
        charted: whether the value is evaluated in t = alpha / rho, m = mu / rho and rho = alpha + mu, where
            no power of alpha and mu underflows: the same function, also good in half precision.

    Raises `EcfitError` for features that repeat, a number of ratios that is not the head's, and ratios
    without terms.
    """

    head: Head
    features: tuple[str, ...]
    numerators: tuple[np.ndarray, ...]
    denominator: np.ndarray
    charted: bool = False

    def __post_init__(self) -> None:
        for name in self.features:
            feature(str(name))
        if not self.features or len(set(self.features)) < len(self.features):
            raise EcfitError("a structured form needs features, each once")
        if len(self.numerators) != self.head.ratios:
            raise EcfitError(
                f"head '{self.head.name}' needs {self.head.ratios} numerators, got {len(self.numerators)}"
            )
        made = tuple(_exponents(n, self.features, "numerator") for n in self.numerators)
        denominator = _exponents(self.denominator, self.features, "denominator")
        if not all(len(n) for n in made) or not len(denominator):
            raise EcfitError("every numerator and the denominator need at least one term")
        object.__setattr__(self, "numerators", made)
        object.__setattr__(self, "denominator", denominator)
        self.head.orders(self.ratio_orders)
        if not isinstance(self.charted, bool):
            raise EcfitError(f"charted must be true or false, got {self.charted!r}")
        if self.charted and not {"alpha", "mu"} <= set(self.variables):
            raise EcfitError("charted is for forms of alpha and mu: leave it out, or use features of both")

    @property
    def least_mu(self) -> float:
        """Cosines are raised to this where the form is evaluated, if at all."""
        return LEAST_HALF if self.charted else LEAST_MU

    @property
    def groups(self) -> tuple[np.ndarray, ...]:
        """Exponents of the free coefficients: the numerators, then Q without its first term."""
        return (*self.numerators, self.denominator[1:])

    @property
    def count(self) -> int:
        """Number of free coefficients."""
        return sum(map(len, self.groups))

    @cached_property
    def variables(self) -> tuple[str, ...]:
        """The coordinates that the form is a function of."""
        return coordinates_of((*self.features, *self.head.features))

    @cached_property
    def corner(self) -> bool:
        """Whether the form needs the corner chart: Q vanishes at alpha = mu = 0."""
        return self._lowest(self.denominator) > 0.0

    def _lowest(self, exponents: np.ndarray) -> float:
        orders = np.array([FEATURES[f].order for f in self.features])
        return float((exponents @ orders).min())

    @cached_property
    def group_orders(self) -> tuple[float, ...]:
        """Lowest order at the corner of each numerator, then of Q."""
        return tuple(self._lowest(e) for e in (*self.numerators, self.denominator))

    @property
    def ratio_orders(self) -> tuple[float, ...]:
        """Order of each ratio P / Q at the corner alpha = mu = 0."""
        *numerators, denominator = self.group_orders
        return tuple(n - denominator for n in numerators)

    def terms(self, exponents: np.ndarray, lowest: float) -> list[Node]:
        """The products of powers of features in the corner chart, divided by rho^lowest."""
        nodes = {f: scaled(f) for f in self.features}
        orders = np.array([FEATURES[f].order for f in self.features])
        out = []
        for row in exponents:
            node = monomial(dict(zip(self.features, map(float, row), strict=True)), nodes)
            out.append(node * rho_power(float(row @ orders) - lowest))
        return out

    def split(self, coefficients: Sequence[float] | np.ndarray) -> list[np.ndarray]:
        """Coefficients of each numerator, then of Q with its leading 1."""
        ends = np.cumsum([len(g) for g in self.groups])
        parts = np.split(np.asarray(coefficients, dtype=np.float64), ends[:-1])
        parts[-1] = np.concatenate([[1.0], parts[-1]])
        return parts

    def polynomials(self, coefficients: np.ndarray, in_chart: bool = False) -> list[Node]:
        """The numerators and Q as expressions; in the chart, each divided by its own lowest power of rho.

        Nested as they are evaluated; sums of terms in the chart, where bounds are the tighter so.
        """
        groups = (*self.numerators, self.denominator)
        parts = self.split(coefficients)
        if not in_chart:
            nodes = {f: plain(f) for f in self.features}
            return [nested(e, c, self.features, nodes) for e, c in zip(groups, parts, strict=True)]
        out = []
        for exponents, values, lowest in zip(groups, parts, self.group_orders, strict=True):
            total = const(0.0)
            for c, node in zip(values, self.terms(exponents, lowest), strict=True):
                total = total + (const(float(c) * node.value) if node.op == "const" else node * float(c))
            out.append(total)
        return out

    def expression(self, coefficients: np.ndarray) -> Node:
        """The value in the coordinates, defined on the whole closed domain."""
        if self.charted:
            return self._evaluated(self.chart(coefficients)[0])
        *numerators, q = self.polynomials(coefficients)
        return self._evaluated(self.head.expression([p / q for p in numerators]))

    def divisor(self, coefficients: np.ndarray) -> Node:
        """Q as `expression` divides by it; divided by its lowest power of rho where that is `charted`."""
        return self._evaluated(self.polynomials(coefficients, self.charted)[-1])

    def _evaluated(self, node: Node) -> Node:
        """With cosines raised and, if `charted`, with t, m and rho written in the coordinates."""
        mu = maximum(var("mu"), self.least_mu)
        if self.charted:
            alpha = var("alpha")
            rho = alpha + mu
            return substitute(untied(node), {"t": alpha / rho, "m": mu / rho, "rho": rho, "mu": mu})
        if self.corner or not _AT_CORNER.isdisjoint((*self.features, *self.head.features)):
            return substitute(node, {"mu": mu})
        return node

    def landmarks(self, coefficients: np.ndarray) -> dict[str, Node]:
        """Features, Q and what the head defines as parts of `expression`, by name."""
        known: dict[str, Node] = {"q": self.divisor(coefficients)}
        for name in (*self.features, *self.head.features):
            known[name] = self._evaluated((scaled if self.charted else plain)(name))
        if self.charted:
            return known | {name: self._evaluated(var(name)) for name in ("t", "m", "rho")}
        *numerators, q = self.polynomials(coefficients)
        lets = self.head.definitions([p / q for p in numerators])
        return known | {name: self._evaluated(node) for name, node in lets.items()}

    def denominator_expression(self, coefficients: np.ndarray) -> Node:
        """Q in the coordinates."""
        return self.polynomials(coefficients)[-1]

    def chart(self, coefficients: np.ndarray) -> tuple[Node, tuple[Node, ...], Node]:
        """Value, what the head holds >= 0, and Q' in the corner chart (t, rho and other coordinates)."""
        *numerators, q = self.polynomials(coefficients, in_chart=True)
        value, held = self.head.in_chart([p / q for p in numerators], self.ratio_orders)
        return value, held, q

    def columns(self, points: Mapping[str, np.ndarray]) -> list[np.ndarray]:
        """Values of all terms in the chart at points, one array (rows, terms) a numerator and Q."""
        inputs = chart_points(points)
        groups = (*self.numerators, self.denominator)
        nodes = [self.terms(e, low) for e, low in zip(groups, self.group_orders, strict=True)]
        return [_stack(n, inputs) for n in nodes]

    def factors(self, points: Mapping[str, np.ndarray]) -> np.ndarray:
        """What multiplies each P_i' / Q' at points, shape (ratios, rows); see `Head.chart_factors`."""
        return _stack(self.head.chart_factors(self.ratio_orders, {}), chart_points(points)).T

    def held_factors(self, points: Mapping[str, np.ndarray]) -> np.ndarray:
        """The same for each of what the head holds >= 0, shape (held, ratios, rows)."""
        inputs = chart_points(points)
        found = [
            _stack(self.head.chart_factors(self.ratio_orders, h.shared), inputs).T for h in self.head.held
        ]
        rows = len(np.broadcast_arrays(*inputs.values())[0])
        return np.stack(found) if found else np.empty((0, self.head.ratios, rows))

    def data(self, points: Mapping[str, np.ndarray]) -> np.ndarray:
        """The features that the head's formulas name at points, shape (names, rows)."""
        inputs = chart_points(points)
        return _stack([*self.head.chart_inputs(), var("rho")], inputs).T[:-1]

    def without_unused(self) -> "Structure":
        """The same function of the same variables with features that no term uses dropped."""
        used = [
            any(np.any(e[:, i] > 0) for e in (*self.numerators, self.denominator))
            for i in range(len(self.features))
        ]
        for i, name in enumerate(self.features):
            # One that is the last of a variable, or of all, stays.
            kept = [f for f, u in zip(self.features, used, strict=True) if u]
            found = set(coordinates_of((*kept, *self.head.features)))
            used[i] = used[i] or not set(coordinates_of([name])) <= found or not (kept or i < len(used) - 1)
        return replace(
            self,
            features=tuple(f for f, u in zip(self.features, used, strict=True) if u),
            numerators=tuple(n[:, used] for n in self.numerators),
            denominator=self.denominator[:, used],
        )

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back."""
        return {
            "head": asdict(self.head),  # whole, whatever its name: files outlive what a name means
            "features": list(self.features),
            "numerators": [n.tolist() for n in self.numerators],
            "denominator": self.denominator.tolist(),
            **({"charted": True} if self.charted else {}),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Structure":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError or TypeError for anything else."""
        features = tuple(str(f) for f in data["features"])
        numerators = tuple(_exponents(n, features, "numerator") for n in data["numerators"])
        denominator, charted = np.asarray(data["denominator"]), data.get("charted", False)
        return cls(head_from(data["head"]), features, numerators, denominator, charted)


def head_from(data: Any) -> Head:
    """A head from its name or from a mapping of its fields. Raises `EcfitError` for anything else."""
    if isinstance(data, Head):
        return data
    if isinstance(data, str):
        return head(data)
    if not isinstance(data, Mapping):
        raise EcfitError(f"a head is a name or a table of its fields, got {data!r}")
    given = dict(data)
    for name in given:
        if name not in Head.__dataclass_fields__:
            raise unknown("field of a head", name, Head.__dataclass_fields__)
    for name in ("name", "factors", "text"):
        if name not in given:
            raise EcfitError(f"a head needs {name}")
    if not isinstance(given["factors"], list | tuple) or not all(
        isinstance(f, Mapping) for f in given["factors"]
    ):
        raise EcfitError("factors of a head must be a list, a table of powers such as { alpha = 2 } a ratio")
    try:
        given["factors"] = tuple(dict(f) for f in given["factors"])
        given["lets"] = tuple((str(n), str(t)) for n, t in given.get("lets", ()))
        return Head(**given)
    except (AttributeError, TypeError, ValueError) as error:
        raise EcfitError(f"head '{given['name']}': malformed ({error})") from None


def chart_points(points: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Points given in the coordinates (with alpha and mu, or neither), in the corner chart.

    At alpha = mu = 0 every direction is a limit; t = 0 (alpha = 0 first) is taken, as `Structure.expression`
    does.
    """
    out = {n: np.asarray(p, dtype=np.float64) for n, p in points.items() if n in COORDINATES}
    alpha, mu = out.get("alpha", np.zeros(1)), out.get("mu", np.zeros(1))
    rho = alpha + mu
    with np.errstate(invalid="ignore", divide="ignore"):
        out["t"] = np.where(rho > 0.0, alpha / rho, 0.0 if "mu" in out else 1.0)
    out["rho"] = rho
    return out


def _stack(nodes: Sequence[Node], inputs: Mapping[str, np.ndarray]) -> np.ndarray:
    shape = np.broadcast_shapes(*(v.shape for v in inputs.values()))
    values = evaluate(nodes, inputs, NUMPY, float)
    return np.stack([np.broadcast_to(v, shape) for v in values], axis=-1)
