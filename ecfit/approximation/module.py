"""An Equinox module with its coefficients."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import equinox as eqx
import numpy as np

from ecfit._jax import jnp
from ecfit.approximation.formula import Array, Box, Formula, broadcast
from ecfit.approximation.written import smallest_divisor
from ecfit.errors import EcfitError
from ecfit.expressions import Node
from ecfit.forms import Minimum
from ecfit.forms.modules import Record, coefficients_of, evaluated, labels_of, with_coefficients


@dataclass(frozen=True, eq=False)
class ModuleFormula(Formula):
    """A user's module (see `ecfit.forms.ModuleForm`), fitted.

    A file holds the registered name, settings and coefficients, never code: it can be read where that name is
    registered.

    Attributes:
        module: with its coefficients.
        names: coordinates that it is called with, in order.
        record: its registered name and settings; None where it has none, and cannot be written.

    Raises `EcfitError` for coefficients that are not finite.
    """

    kind: ClassVar[str] = "module"

    module: eqx.Module
    names: tuple[str, ...]
    record: Record | None = None

    def __post_init__(self) -> None:
        if not np.all(np.isfinite(self.coefficients)):
            raise EcfitError("coefficients must be finite")
        # In float64, whatever the user's arrays are.
        made = with_coefficients(self.module)(jnp.asarray(self.coefficients))
        object.__setattr__(self, "module", made)

    @property
    def variables(self) -> int:
        return len(self.names)

    @property
    def coefficients(self) -> np.ndarray:
        return self._coefficients

    @cached_property
    def _coefficients(self) -> np.ndarray:
        values = coefficients_of(self.module)
        values.setflags(write=False)
        return values

    def value(self, points: Sequence[Array]) -> Array:
        arrays = broadcast(points)
        made = evaluated(self.module, self.names, [jnp.asarray(a, dtype=jnp.float64) for a in arrays])
        return np.asarray(made) if isinstance(arrays[0], np.ndarray) else made

    def expression(self, names: Sequence[str]) -> Node:
        own = getattr(self.module, "expression", None)
        if own is not None:
            return own(tuple(names))
        raise EcfitError(
            f"the module {type(self.module).__name__} has no expression: it cannot be certified or exported"
        )

    def smallest_denominator(self, domain: Box) -> Minimum:
        """What the module or its expression says; else 1: poles are then unknown, not excluded."""
        own = getattr(self.module, "smallest_denominator", None)
        if own is None and hasattr(self.module, "expression"):
            return smallest_divisor(self.expression(self.names), self.names, domain)
        return own(domain) if own is not None else Minimum(1.0, tuple(low for low, _ in domain), 1.0)

    def rows(self, names: Sequence[str]) -> list[tuple[str, float]]:
        return list(zip(labels_of(self.module), map(float, self.coefficients), strict=True))

    def to_dict(self) -> dict[str, Any]:
        """See `Formula`. Raises `EcfitError` for a module that is not registered."""
        if self.record is None:
            raise EcfitError(
                f"a fit of the module {type(self.module).__name__} cannot be saved: decorate its class with "
                "@ecfit.register_form(...) and fit ModuleForm(name, settings), so that a file can name it"
            )
        return {
            "module": self.record.name,
            "settings": dict(self.record.settings),
            "coefficients": self.coefficients.tolist(),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], variables: int) -> "ModuleFormula":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError, TypeError or ValueError otherwise."""
        record = Record(str(data["module"]), dict(data["settings"]))
        made = record.made(np.asarray(data["coefficients"], dtype=np.float64))
        return cls(made, tuple(str(v) for v in data["variables"]), record)
