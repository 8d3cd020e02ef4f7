"""`Approximation`: an evaluated form that knows its coordinates, domain and contract."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
        numerator, denominator = self.terms.parts(jnp.asarray(self.coefficients), points)
        return numerator / denominator

    def denominator(self, **coordinates: Any) -> Array:
        """The denominator Q at physical coordinates."""
        return self.terms.parts(jnp.asarray(self.coefficients), self._points(coordinates))[1]

    def _points(self, coordinates: Mapping[str, Any]) -> list[Array]:
        found = resolve(self.variables, coordinates)
        return [jnp.asarray(found[v], dtype=jnp.float64) for v in self.variables]

    def smallest_denominator(self) -> Minimum:
        """The minimum of Q over the whole domain (not only on nodes), with a lower bound."""
        return smallest_denominator(self.terms, self.coefficients, self.domain)

    def to_dict(self) -> dict:
        """A JSON-ready dictionary that `from_dict` reads back exactly."""
        return {
            "name": self.name,
            "form": self.form,
            "degree": self.degree,
            "variables": list(self.variables),
            "domain": [list(d) for d in self.domain],
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
            )
        except EcfitError as error:
            raise EcfitError(f"{where}: {error}") from None
        except KeyError as error:
            raise EcfitError(f"{where}: the key {error} is missing") from None
        except (TypeError, ValueError, OverflowError) as error:
            raise EcfitError(f"{where}: malformed ({error})") from None
