"""Formulas written as text with numbers left free: a published form refitted, or any formula of one's own."""

from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError
from ecfit.expressions import Node, parse, substitute, value, var
from ecfit.expressions.node import const, inputs
from ecfit.forms.modules import register_form

Array = jax.Array


@register_form("written")
class WrittenForm(eqx.Module):
    """The value of a formula (see `ecfit.expressions.parse`) whose named numbers are the coefficients.

    Args:
        formula: the value, in the variables, the constants, and what `let` defines.
        constants: name -> value to start from, one or more: what a fit may change.
        variables: names of coordinates, in any view.
        let: (name, text) pairs defined before the formula.

    Raises `EcfitError` for text that cannot be read, and for a constant that is not used.
    """

    numbers: Array
    formula: str = eqx.field(static=True)
    names: tuple[str, ...] = eqx.field(static=True)
    variables: tuple[str, ...] = eqx.field(static=True)
    let: tuple[tuple[str, str], ...] = eqx.field(static=True)

    def __init__(
        self,
        formula: str,
        constants: Mapping[str, float],
        variables: Sequence[str],
        let: Sequence[Sequence[str]] = (),
    ) -> None:
        self.formula, self.names, self.variables = formula, tuple(constants), tuple(variables)
        self.let = tuple((str(name), str(text)) for name, text in let)
        self.numbers = jnp.asarray([float(v) for v in constants.values()], dtype=jnp.float64)
        if not self.names:
            raise EcfitError("a written form needs constants to fit: name one or more")
        known = [*self.names, *self.variables]
        for name in known:
            if known.count(name) > 1:
                raise EcfitError(f"'{name}' is named twice among the constants and variables")
            # A formula may neglect a coordinate of its table; a constant that it has not cannot be fitted.
            if name in self.names and name not in inputs(self._root):
                raise EcfitError(f"'{name}' does not occur in the formula: leave it out")

    @property
    def degree(self) -> str:
        """The number of free numbers."""
        return str(len(self.names))

    @property
    def _root(self) -> Node:
        return parse(self.formula, [*self.variables, *self.names], self.let)

    def __call__(self, **coordinates: Any) -> Array:
        points = resolve(self.variables, {n: jnp.asarray(v) for n, v in coordinates.items()})
        numbers = {name: self.numbers[i] for i, name in enumerate(self.names)}
        # A formula in which some variable cancels still has the points' shape.
        shape = jnp.broadcast_shapes(*(jnp.shape(v) for v in points.values()))
        return jnp.broadcast_to(value(self._root, {**points, **numbers}), shape)

    def expression(self, names: Sequence[str]) -> Node:
        """The value as an expression of `names`, which stand for `variables` in their order."""
        replacements = {n: const(float(self.numbers[i])) for i, n in enumerate(self.names)}
        return substitute(
            self._root, {**replacements, **{v: var(n) for v, n in zip(self.variables, names, strict=True)}}
        )

    def labels(self) -> list[str]:
        """Names of the coefficients."""
        return list(self.names)
