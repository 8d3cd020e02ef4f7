"""`Approximation`: a formula that knows its coordinates, domain and contract."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.approximation.composed import Composed
from ecfit.approximation.formula import Formula, Quotient
from ecfit.approximation.lookup import Lookup
from ecfit.approximation.module import ModuleFormula
from ecfit.approximation.structured import StructuredFormula
from ecfit.approximation.written import Written
from ecfit.contract import Contract
from ecfit.coordinates import resolve, viewed
from ecfit.display import facts
from ecfit.errors import EcfitError, unknown
from ecfit.expressions import Node
from ecfit.forms import Minimum, Terms
from ecfit.tables import Table

Array = jax.Array

KINDS: dict[str, Any] = {
    k.kind: k for k in (Quotient, StructuredFormula, Written, Lookup, Composed, ModuleFormula)
}


# The source of what nobody else published.
OURS = "ecfit"


@dataclass(frozen=True, eq=False)
class Approximation:
    """A formula in stated coordinates, approximating a quantity under a contract.

    Attributes:
        name: for people and reports.
        form, degree: the family in words ("rational", "3").
        variables: names of the coordinates, in the order of the formula's ("r", "mu").
        formula: how the value is computed.
        domain: (low, high) of each variable.
        contract: the conventions of what is approximated.
        source: who published it, or `OURS`.

    Raises `EcfitError` unless variables, domain and formula agree in number, with low < high everywhere.
    """

    name: str
    form: str
    degree: str
    variables: tuple[str, ...]
    formula: Formula
    domain: tuple[tuple[float, float], ...]
    contract: Contract
    source: str = OURS

    def __post_init__(self) -> None:
        if not isinstance(self.formula, Formula):
            raise EcfitError(f"'{self.name}': expected a formula, got {type(self.formula).__name__}")
        if not (len(self.variables) == len(self.domain) == self.formula.variables):
            raise EcfitError(f"'{self.name}': variables, domain and formula differ in number")
        if any(not low < high for low, high in self.domain):
            raise EcfitError(f"'{self.name}': the domain must have low < high in each variable")

    @classmethod
    def quotient(
        cls,
        name: str,
        form: str,
        degree: str,
        variables: tuple[str, ...],
        terms: Terms,
        coefficients: np.ndarray,
        domain: tuple[tuple[float, float], ...],
        contract: Contract,
        source: str = OURS,
        scales: tuple[tuple[float, float], ...] = (),
    ) -> "Approximation":
        """A quotient of polynomials; see `Quotient` for terms, coefficients and scales.

        Raises `EcfitError` for coefficients that are not finite, or not as many as the terms.
        """
        try:
            formula = Quotient(terms, np.asarray(coefficients), scales)
        except EcfitError as error:
            raise EcfitError(f"'{name}': {error}") from None
        return cls(name, form, degree, variables, formula, domain, contract, source)

    @classmethod
    def lookup(cls, table: Table, name: str | None = None) -> "Approximation":
        """Multilinear look-up in a table whose nodes are uniform (through a map), as a renderer would.

        Raises `EcfitError` for other spacings and entries that are not finite.
        """
        for axis in table.axes:
            if axis.spacing != "uniform":
                raise EcfitError(f"look-up: axis '{axis.name}' must be uniform, not {axis.spacing}")
        label = name or "table-" + "x".join(map(str, table.grid.shape))
        formula = Lookup(table.values, table.grid.domain, tuple(a.through for a in table.axes))
        return cls(label, "lookup", "1", table.names, formula, table.grid.domain, table.contract)

    def __repr__(self) -> str:
        ends = ", ".join(
            f"{v} in [{low:g}, {high:g}]" for v, (low, high) in zip(self.variables, self.domain, strict=True)
        )
        return (
            f"<Approximation {self.name}: {self.contract.quantity} of {self.contract.model}, "
            f"{self.count} numbers, {ends}>"
        )

    def _repr_html_(self) -> str:
        ends = [
            (v, f"{low:g} to {high:g}") for v, (low, high) in zip(self.variables, self.domain, strict=True)
        ]
        rows = [("source", self.source), ("numbers", self.count), *ends, *self.contract.describe()]
        return facts(self.name, rows)

    @property
    def coefficients(self) -> np.ndarray:
        """The formula's numbers, float64."""
        return self.formula.coefficients

    @property
    def count(self) -> int:
        """How many numbers one has to store."""
        return self.formula.count

    @property
    def terms(self) -> Terms:
        """Exponents of a quotient. Raises `EcfitError` for other formulas."""
        return self._quotient.terms

    @property
    def scales(self) -> tuple[tuple[float, float], ...]:
        """(origin, unit) of each variable of a quotient. Raises `EcfitError` for other formulas."""
        return self._quotient.scales

    @property
    def _quotient(self) -> Quotient:
        if not isinstance(self.formula, Quotient):
            raise EcfitError(f"'{self.name}' is not a quotient of polynomials but {self.formula.kind}")
        return self.formula

    @property
    def module(self) -> eqx.Module:
        """The Equinox module that the formula is, its arrays the coefficients.

        Raises `EcfitError` for formulas of other kinds.
        """
        if not isinstance(self.formula, ModuleFormula):
            raise EcfitError(f"'{self.name}' is not a module but {self.formula.kind}")
        return self.formula.module

    @property
    def is_quotient(self) -> bool:
        """Whether the formula is a quotient of polynomials."""
        return isinstance(self.formula, Quotient)

    def __call__(self, **coordinates: Any) -> Array:
        """The value at physical coordinates, in any view (`r` or `alpha`, ...); arrays broadcast.

        Works under jit, vmap and grad. Nothing is clamped: outside `domain` it extrapolates.
        Raises `EcfitError` for missing or unknown coordinates.
        """
        return self.at(self._points(coordinates))

    def at(self, points: Sequence[Any]) -> Array:
        """The value at points given as one array a variable, in the order of `variables`."""
        return self.formula.value([jnp.asarray(p) for p in points])

    def parts(self, points: Sequence[Any]) -> tuple[Any, Any]:
        """P and Q of a quotient at points given as one array a variable; NumPy in, NumPy out."""
        return self._quotient.parts(points)

    def on_grid(self, nodes: Sequence[np.ndarray]) -> np.ndarray:
        """The value, NumPy, on the tensor product of nodes given as one array a variable."""
        return self.formula.on_grid(nodes)

    def denominator(self, **coordinates: Any) -> Array:
        """The denominator Q of a quotient at physical coordinates."""
        return self.parts(self._points(coordinates))[1]

    def expression(self) -> Node:
        """The value as an expression of `variables`. Raises `EcfitError` for tables."""
        return self.formula.expression(self.variables)

    def to_code(self, language: str, **options: Any) -> str:
        """Source text of a function that computes this; see `ecfit.export.code`."""
        from ecfit.export import code

        return code(self, language, **options)

    def _points(self, coordinates: Mapping[str, Any]) -> list[Array]:
        found = resolve(self.variables, coordinates)
        return [jnp.asarray(found[v], dtype=jnp.float64) for v in self.variables]

    def nodes_of(
        self, axes: Mapping[str, np.ndarray], fixed: Mapping[str, float] | None = None
    ) -> tuple[list[np.ndarray], list[int]]:
        """Nodes of `variables` from those of axes in any view, and the axis of each.

        Variables without an axis take their value from `fixed` (a contract's parameters), as axes of one node
        after the others. Raises `EcfitError` unless axes and variables correspond one to one.
        """
        nodes, order = [], []
        given = {n: np.array([v]) for n, v in (fixed or {}).items() if self._lacks(n, axes)}
        axes = {**axes, **given}
        for variable in self.variables:
            for i, (name, values) in enumerate(axes.items()):
                found = viewed(variable, name, values)
                if found is not None:
                    nodes.append(np.asarray(found))
                    order.append(i)
                    break
        if len(nodes) != len(self.variables) or sorted(order) != list(range(len(axes))):
            raise EcfitError(
                f"'{self.name}' is a function of {', '.join(self.variables)}, the table of {', '.join(axes)}"
            )
        return nodes, order

    def _lacks(self, parameter: str, axes: Mapping[str, np.ndarray]) -> bool:
        """Whether a variable stands for the parameter, and for none of the axes."""
        return any(
            viewed(variable, parameter, 0.5) is not None
            and all(viewed(variable, name, 0.5) is None for name in axes)
            for variable in self.variables
        )

    def smallest_denominator(self) -> Minimum:
        """The minimum of the denominator over the whole domain (not only on nodes), with a lower bound."""
        return self.formula.smallest_denominator(self.domain)

    def with_quotient(self, **changes: Any) -> "Approximation":
        """The same with other `values` (coefficients), `scales` or `terms` of its quotient.

        Raises `EcfitError` where the formula is no quotient, and for parts that do not fit together.
        """
        try:
            return replace(self, formula=replace(self._quotient, **changes))
        except EcfitError as error:
            raise EcfitError(f"'{self.name}': {error}") from None

    def in_scales(self, scales: Sequence[tuple[float, float]]) -> "Approximation":
        """The same quotient with monomials of (x - origin) / unit: other coefficients, equal values.

        Raises `EcfitError` where the denominator vanishes at the new origin, as it then has no constant 1.
        """
        try:
            return replace(self, formula=self._quotient.in_scales(scales))
        except EcfitError as error:
            raise EcfitError(f"'{self.name}': {error}") from None

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back exactly."""
        return {
            "name": self.name,
            "form": self.form,
            "degree": self.degree,
            "kind": self.formula.kind,
            "variables": list(self.variables),
            "domain": [list(d) for d in self.domain],
            **self.formula.to_dict(),
            "contract": self.contract.to_dict(),
            "source": self.source,
        }

    @classmethod
    def from_dict(cls, data: Any, where: str = "approximation") -> "Approximation":
        """Read what `to_dict` wrote; raises `EcfitError` for anything else."""
        if not isinstance(data, Mapping):
            raise EcfitError(f"{where}: expected a mapping")
        try:
            variables = tuple(str(v) for v in data["variables"])
            kind = data.get("kind", Quotient.kind)
            if not isinstance(kind, str) or kind not in KINDS:
                raise unknown("kind of formula", kind, KINDS)
            return cls(
                name=str(data["name"]),
                form=str(data["form"]),
                degree=str(data["degree"]),
                variables=variables,
                formula=KINDS[kind].from_dict(data, len(variables)),
                domain=tuple((float(low), float(high)) for low, high in data["domain"]),
                contract=Contract.from_dict(data["contract"]),
                source=str(data["source"]),
            )
        except EcfitError as error:
            raise EcfitError(f"{where}: {error}") from None
        except KeyError as error:
            raise EcfitError(f"{where}: the key {error} is missing") from None
        except (TypeError, ValueError, OverflowError, AttributeError) as error:
            raise EcfitError(f"{where}: malformed ({error})") from None
