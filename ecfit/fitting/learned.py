"""Learned coordinate maps: exponents that are fitted together with the coefficients."""

from collections.abc import Mapping, Sequence
from math import comb
from typing import Any

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError
from ecfit.forms import Minimum, Rational, Terms, smallest_denominator
from ecfit.forms.modules import register_form
from ecfit.tables import Table

_MOST = 2000


@register_form("learned-rational")
class LearnedRational(eqx.Module):
    """A rational of a total degree in x_v^p_v, with an exponent p_v for each coordinate of the table.

    The start is the plain rational (all p_v = 1), so that it is never worse than that on the table's nodes.

    Args:
        degree: of numerator and denominator, 1..20.
        variables: coordinates, >= 0; those of the table by default.
    """

    exponents: jax.Array
    coefficients: jax.Array
    degree: int = eqx.field(static=True)
    variables: tuple[str, ...] = eqx.field(static=True)

    def __init__(self, degree: int, variables: Sequence[str] = ()) -> None:
        Rational(degree)  # refuses other degrees
        self.degree, self.variables = int(degree), tuple(map(str, variables))
        n = len(self.variables)
        if comb(n + degree, degree) > _MOST:
            raise EcfitError(f"degree {degree} in {n} variables has too many terms: lower the degree")
        self.exponents = jnp.ones(n)
        self.coefficients = jnp.zeros(self._terms.count if n else 0)

    @property
    def _terms(self) -> Terms:
        return Rational(self.degree).terms(len(self.variables))

    def started(self, table: Table) -> "LearnedRational":
        """With the coefficients of the table's plain rational fit."""
        from ecfit.fitting.fit import fit

        for axis in table.axes:
            if axis.low < 0.0:
                raise EcfitError(
                    f"learned-rational: axis '{axis.name}' is negative, where x^p is not defined"
                )
        if self.variables not in ((), table.names):
            raise EcfitError(
                f"learned-rational is a function of {', '.join(self.variables)}: the table has "
                f"{', '.join(table.names)}"
            )
        plain = fit(table, Rational(self.degree)).coefficients
        made = LearnedRational(self.degree, table.names)
        return eqx.tree_at(lambda m: m.coefficients, made, jnp.asarray(plain))

    def __call__(self, **coordinates: Any) -> Any:
        numerator, denominator = self._parts(coordinates)
        return numerator / denominator

    def denominator(self, **coordinates: Any) -> Any:
        """Q, which a fit keeps positive."""
        return self._parts(coordinates)[1]

    def _parts(self, coordinates: Mapping[str, Any]) -> tuple[Any, Any]:
        points = [
            self._mapped(coordinates[n], p) for n, p in zip(self.variables, self.exponents, strict=True)
        ]
        return self._terms.parts(self.coefficients, points)

    @staticmethod
    def _mapped(x: Any, exponent: Any) -> Any:
        # 0 stays 0 for every exponent; the inner choice keeps the derivative finite there.
        x = jnp.asarray(x)
        return jnp.where(x > 0.0, jnp.where(x > 0.0, x, 1.0) ** exponent, 0.0)

    def smallest_denominator(self, domain: Sequence[tuple[float, float]]) -> Minimum:
        """The minimum of Q over the domain: that of a polynomial over the mapped box."""
        powers = np.asarray(self.exponents)
        if np.any(powers <= 0.0):  # x^p is not bounded at 0, or falls: no map of coordinates any more
            return Minimum(0.0, tuple(low for low, _ in domain), -np.inf)
        box = [(low**p, high**p) for (low, high), p in zip(domain, powers, strict=True)]
        found = smallest_denominator(self._terms, np.asarray(self.coefficients), box)
        return found._replace(
            place=tuple(float(x ** (1.0 / p)) for x, p in zip(found.place, powers, strict=True))
        )
