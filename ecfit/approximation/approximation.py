"""`Approximation`: an evaluated form that knows its coordinates, domain and contract."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.contract import Contract
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError
from ecfit.forms import Minimum, Terms, smallest_denominator

Array = jax.Array


@dataclass(frozen=True, eq=False)
class Approximation:
    """A quotient of polynomials in stated coordinates, approximating a quantity under a contract.

    Attributes:
        name: for people and reports.
        form, degree: the family in words ("rational", "3").
        variables: names of the coordinates, in the order of the exponents ("r", "mu").
        terms: exponents of numerator and denominator.
        coefficients: float64, numerator then denominator (whose constant 1 is implied).
        domain: (low, high) of each variable.
        contract: the conventions of what is approximated.
        source: who published it, or "ecfit".
        scales: (origin, unit) of each variable x: the monomials are those of (x - origin) / unit.
            By default (0, 1).
    """

    name: str
    form: str
    degree: str
    variables: tuple[str, ...]
    terms: Terms
    coefficients: np.ndarray
    domain: tuple[tuple[float, float], ...]
    contract: Contract
    source: str = "ecfit"
    scales: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        coefficients = np.array(self.coefficients, dtype=np.float64)
        if coefficients.shape != (self.terms.count,):
            raise EcfitError(
                f"'{self.name}': {self.terms.count} coefficients expected, got shape {coefficients.shape}"
            )
        if not np.all(np.isfinite(coefficients)):
            raise EcfitError(f"'{self.name}': coefficients must be finite")
        if not (len(self.variables) == len(self.domain) == self.terms.variables):
            raise EcfitError(f"'{self.name}': variables, domain and exponents differ in number")
        if any(not low < high for low, high in self.domain):
            raise EcfitError(f"'{self.name}': the domain must have low < high in each variable")
        scales = self.scales or ((0.0, 1.0),) * self.terms.variables
        if len(scales) != self.terms.variables or not all(
            np.isfinite(s).all() and s[1] > 0.0 for s in scales
        ):
            raise EcfitError(f"'{self.name}': scales must be one (origin, unit > 0) for each variable")
        object.__setattr__(self, "scales", tuple((float(o), float(u)) for o, u in scales))
        coefficients.setflags(write=False)
        object.__setattr__(self, "coefficients", coefficients)

    def __call__(self, **coordinates: Any) -> Array:
        """The value at physical coordinates, in any view (`r` or `alpha`, ...); arrays broadcast.

        Works under jit, vmap and grad. Nothing is clamped: outside `domain` it extrapolates.
        Raises `EcfitError` for missing or unknown coordinates.
        """
        return self.at(self._points(coordinates))

    def at(self, points: Sequence[Any]) -> Array:
        """The value at points given as one array a variable, in the order of `variables`."""
        numerator, denominator = self.parts([jnp.asarray(p) for p in points])
        return numerator / denominator

    def parts(self, points: Sequence[Any]) -> tuple[Any, Any]:
        """P and Q at points given as one array a variable; NumPy in, NumPy out."""
        scaled = [(p - origin) / unit for p, (origin, unit) in zip(points, self.scales, strict=True)]
        return self.terms.parts(self.coefficients, scaled)

    def on_grid(self, nodes: Sequence[np.ndarray]) -> np.ndarray:
        """The value, NumPy, on the tensor product of nodes given as one array a variable."""
        scaled = [(np.asarray(n) - o) / u for n, (o, u) in zip(nodes, self.scales, strict=True)]
        numerator, denominator = self.terms.on_grid(self.coefficients, scaled)
        with np.errstate(divide="ignore", invalid="ignore"):
            return numerator / denominator

    def denominator(self, **coordinates: Any) -> Array:
        """The denominator Q at physical coordinates."""
        return self.parts(self._points(coordinates))[1]

    def _points(self, coordinates: Mapping[str, Any]) -> list[Array]:
        found = resolve(self.variables, coordinates)
        return [jnp.asarray(found[v], dtype=jnp.float64) for v in self.variables]

    def smallest_denominator(self) -> Minimum:
        """The minimum of Q over the whole domain (not only on nodes), with a lower bound."""
        box = [
            ((low - origin) / unit, (high - origin) / unit)
            for (low, high), (origin, unit) in zip(self.domain, self.scales, strict=True)
        ]
        found = smallest_denominator(self.terms, self.coefficients, box)
        place = tuple(o + u * x for x, (o, u) in zip(found.place, self.scales, strict=True))
        return found._replace(place=place)

    def in_scales(self, scales: Sequence[tuple[float, float]]) -> "Approximation":
        """The same function with monomials of (x - origin) / unit: other coefficients, equal values.

        Raises `EcfitError` where the denominator vanishes at the new origin, as it then has no constant 1.
        """
        highest = self.terms.highest
        tables = []
        for (old_origin, old_unit), (origin, unit) in zip(self.scales, scales, strict=True):
            line = np.polynomial.Polynomial([(origin - old_origin) / old_unit, unit / old_unit])
            rows = np.zeros((highest + 1, highest + 1))
            for k in range(highest + 1):
                power = (line**k).coef
                rows[k, : len(power)] = power
            tables.append(rows)
        p, q = self.terms.split(self.coefficients)
        coefficients = self.terms.converted(p, np.concatenate([[1.0], q]), tables)
        if not np.all(np.isfinite(coefficients)):
            raise EcfitError(f"'{self.name}': the denominator vanishes at the new origin")
        return replace(self, coefficients=coefficients, scales=tuple(scales))

    def to_dict(self) -> dict:
        """A JSON-ready dictionary that `from_dict` reads back exactly."""
        return {
            "name": self.name,
            "form": self.form,
            "degree": self.degree,
            "variables": list(self.variables),
            "domain": [list(d) for d in self.domain],
            "scales": [list(s) for s in self.scales],
            "numerator_exponents": self.terms.numerator.tolist(),
            "denominator_exponents": self.terms.denominator.tolist(),
            "denominator_constant": 1.0,
            "coefficients": self.coefficients.tolist(),
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
            denominator = np.asarray(data["denominator_exponents"]).reshape(-1, len(variables))
            return cls(
                name=str(data["name"]),
                form=str(data["form"]),
                degree=str(data["degree"]),
                variables=variables,
                terms=Terms(np.asarray(data["numerator_exponents"]), denominator),
                coefficients=np.asarray(data["coefficients"], dtype=np.float64),
                domain=tuple((float(low), float(high)) for low, high in data["domain"]),
                contract=Contract.from_dict(data["contract"]),
                source=str(data["source"]),
                scales=tuple((float(o), float(u)) for o, u in data.get("scales", ())),
            )
        except EcfitError as error:
            raise EcfitError(f"{where}: {error}") from None
        except KeyError as error:
            raise EcfitError(f"{where}: the key {error} is missing") from None
        except (TypeError, ValueError, OverflowError) as error:
            raise EcfitError(f"{where}: malformed ({error})") from None
