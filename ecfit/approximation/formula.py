"""`Formula`: how an approximation computes its value; and the quotient of polynomials, the plainest one."""

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ecfit._jax import jnp
from ecfit.errors import EcfitError
from ecfit.expressions import Node, const, power, var
from ecfit.forms import Minimum, Terms, smallest_denominator

Array = Any
Box = Sequence[tuple[float, float]]
# Points evaluated at once: intermediate arrays then stay within the caches.
_BLOCK = 65_536


class Formula(abc.ABC):
    """A function of a few variables, with the numbers that it is made of.

    Final classes: `Quotient`, `StructuredFormula`, `Written`, `Lookup`, `Composed`, `ModuleFormula`. Each
    has a `kind`, the word that files use.
    """

    kind: ClassVar[str]

    @property
    @abc.abstractmethod
    def variables(self) -> int:
        """Number of variables."""

    @property
    @abc.abstractmethod
    def coefficients(self) -> np.ndarray:
        """The numbers, float64, shape (count,)."""

    @property
    def count(self) -> int:
        """How many numbers one has to store."""
        return self.coefficients.size

    @abc.abstractmethod
    def value(self, points: Sequence[Array]) -> Array:
        """The value at points, one array a variable (they broadcast); NumPy in, NumPy out."""

    @abc.abstractmethod
    def expression(self, names: Sequence[str]) -> Node:
        """The value as an expression of variables of these names.

        Raises `EcfitError` where it has none (tables)."""

    def landmarks(self, names: Sequence[str]) -> dict[str, Node]:
        """Subexpressions of `expression` that have a meaning, by what people call them: for readable code."""
        return {}

    @abc.abstractmethod
    def smallest_denominator(self, domain: Box) -> Minimum:
        """The minimum of the denominator over a box; 1 where there is none."""

    def rows(self, names: Sequence[str]) -> list[tuple[str, float]]:
        """(what it multiplies, number) of every coefficient, for people."""
        return [(f"number {i + 1}", float(c)) for i, c in enumerate(self.coefficients)]

    @abc.abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back exactly."""

    def on_grid(self, nodes: Sequence[np.ndarray]) -> np.ndarray:
        """The value, NumPy, on the tensor product of nodes given as one array a variable."""
        shape = tuple(len(n) for n in nodes)
        out = np.empty(int(np.prod(shape)))
        for start in range(0, out.size, _BLOCK):
            index = np.unravel_index(np.arange(start, min(start + _BLOCK, out.size)), shape)
            out[start : start + _BLOCK] = self.value([n[i] for n, i in zip(nodes, index, strict=True)])
        return out.reshape(shape)


@dataclass(frozen=True, eq=False)
class Quotient(Formula):
    """P / Q of polynomials in scaled variables.

    Attributes:
        terms: exponents of numerator and denominator.
        values: coefficients, float64, numerator then denominator (whose constant 1 is implied).
        scales: (origin, unit) of each variable x: the monomials are those of (x - origin) / unit.
            By default (0, 1).

    Raises `EcfitError` for coefficients that are not finite or not as many as the terms, and malformed
    scales.
    """

    kind: ClassVar[str] = "quotient"

    terms: Terms
    values: np.ndarray
    scales: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.float64)
        if values.shape != (self.terms.count,):
            raise EcfitError(f"{self.terms.count} coefficients expected, got shape {values.shape}")
        if not np.all(np.isfinite(values)):
            raise EcfitError("coefficients must be finite")
        scales = self.scales or ((0.0, 1.0),) * self.terms.variables
        if len(scales) != self.terms.variables or not all(
            np.isfinite(s).all() and s[1] > 0.0 for s in scales
        ):
            raise EcfitError("scales must be one (origin, unit > 0) for each variable")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "scales", tuple((float(o), float(u)) for o, u in scales))

    @property
    def variables(self) -> int:
        return self.terms.variables

    @property
    def coefficients(self) -> np.ndarray:
        return self.values

    def parts(self, points: Sequence[Array]) -> tuple[Array, Array]:
        """P and Q at points given as one array a variable; NumPy in, NumPy out."""
        scaled = [(p - origin) / unit for p, (origin, unit) in zip(points, self.scales, strict=True)]
        return self.terms.parts(self.values, scaled)

    def value(self, points: Sequence[Array]) -> Array:
        numerator, denominator = self.parts(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            return numerator / denominator

    def on_grid(self, nodes: Sequence[np.ndarray]) -> np.ndarray:
        scaled = [(np.asarray(n) - o) / u for n, (o, u) in zip(nodes, self.scales, strict=True)]
        numerator, denominator = self.terms.on_grid(self.values, scaled)
        with np.errstate(divide="ignore", invalid="ignore"):
            return numerator / denominator

    def polynomials(self, names: Sequence[str]) -> tuple[Node, Node]:
        """P and Q as expressions."""
        nodes = [
            (var(name) - origin) / unit if origin or unit != 1.0 else var(name)
            for name, (origin, unit) in zip(names, self.scales, strict=True)
        ]
        out = []
        constant = np.zeros((1, self.terms.variables), dtype=np.int64)
        p, q = self.terms.split(self.values)
        for values, exponents in (
            (p, self.terms.numerator),
            (np.concatenate([[1.0], q]), np.concatenate([constant, self.terms.denominator])),
        ):
            total: Node = const(0.0)
            for c, row in zip(values, exponents, strict=True):
                product: Node = const(1.0)
                for node, e in zip(nodes, row, strict=True):
                    product = product * power(node, int(e))
                total = total + product * float(c)
            out.append(total)
        return out[0], out[1]

    def expression(self, names: Sequence[str]) -> Node:
        p, q = self.polynomials(names)
        return p / q

    def landmarks(self, names: Sequence[str]) -> dict[str, Node]:
        return dict(zip("pq", self.polynomials(names), strict=True))

    def smallest_denominator(self, domain: Box) -> Minimum:
        box = [
            ((low - origin) / unit, (high - origin) / unit)
            for (low, high), (origin, unit) in zip(domain, self.scales, strict=True)
        ]
        found = smallest_denominator(self.terms, self.values, box)
        place = tuple(o + u * x for x, (o, u) in zip(found.place, self.scales, strict=True))
        return found._replace(place=place)

    def rows(self, names: Sequence[str]) -> list[tuple[str, float]]:
        p, q = self.terms.split(self.values)
        constant = np.zeros((1, self.terms.variables), dtype=np.int64)
        groups = (
            ("P", self.terms.numerator, p),
            ("Q", np.concatenate([constant, self.terms.denominator]), np.concatenate([[1.0], q])),
        )
        return [
            (f"{label}: {power_product(names, row)}", float(c))
            for label, exponents, values in groups
            for row, c in zip(exponents, values, strict=True)
        ]

    def in_scales(self, scales: Sequence[tuple[float, float]]) -> "Quotient":
        """The same function with monomials of (x - origin) / unit: other coefficients, equal values.

        Raises `EcfitError` where the denominator vanishes at the new origin, as it then has no constant 1.
        """
        highest = self.terms.highest
        tables = []
        for (old_origin, old_unit), (origin, unit) in zip(self.scales, scales, strict=True):
            line = np.polynomial.Polynomial([(origin - old_origin) / old_unit, unit / old_unit])
            rows = np.zeros((highest + 1, highest + 1))
            for k in range(highest + 1):
                power_ = (line**k).coef
                rows[k, : len(power_)] = power_
            tables.append(rows)
        p, q = self.terms.split(self.values)
        values = self.terms.converted(p, np.concatenate([[1.0], q]), tables)
        if not np.all(np.isfinite(values)):
            raise EcfitError("the denominator vanishes at the new origin")
        return replace(self, values=values, scales=tuple(scales))

    def to_dict(self) -> dict[str, Any]:
        return {
            "scales": [list(s) for s in self.scales],
            "numerator_exponents": self.terms.numerator.tolist(),
            "denominator_exponents": self.terms.denominator.tolist(),
            "denominator_constant": 1.0,
            "coefficients": self.values.tolist(),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], variables: int) -> "Quotient":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
        denominator = np.asarray(data["denominator_exponents"]).reshape(-1, variables)
        return cls(
            Terms(np.asarray(data["numerator_exponents"]), denominator),
            np.asarray(data["coefficients"], dtype=np.float64),
            tuple((float(o), float(u)) for o, u in data.get("scales", ())),
        )


def power_product(names: Sequence[str], exponents: Sequence[float] | np.ndarray) -> str:
    """Powers in words: "r mu^2" for the exponents (1, 2) of (r, mu), "1" for none."""
    parts = [name if e == 1 else f"{name}^{e:g}" for name, e in zip(names, exponents, strict=True) if e]
    return " ".join(parts) or "1"


def broadcast(points: Sequence[Array]) -> list[Array]:
    """Points as arrays of one shape: JAX where one is, else NumPy of at least half precision."""
    if any(isinstance(p, jnp.ndarray) for p in points):
        return list(jnp.broadcast_arrays(*(jnp.asarray(p, dtype=jnp.float64) for p in points)))
    return list(np.broadcast_arrays(*(_floating(p) for p in points)))


def _floating(p: Any) -> np.ndarray:
    array = np.asarray(p)
    return array if array.dtype.kind == "f" else array.astype(np.float64)
