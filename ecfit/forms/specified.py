"""Structured forms that a config can name: with given terms, or with terms to be selected."""

from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx
import numpy as np

from ecfit.errors import EcfitError
from ecfit.forms.candidates import Powers, candidates
from ecfit.forms.families import Form
from ecfit.forms.structured import Structure, head_from


class Structured(Form):
    """A head over ratios of sparse polynomials in named features, with given terms.

    Args:
        head: name of `ecfit.forms.HEADS`, or a mapping of a `Head`'s fields.
        features: names of features.
        numerators: for each ratio, rows of exponents, one number a feature.
        denominator: the same for Q; the first term has the coefficient 1.
        start: coefficients to begin from; by default a linearised start, where the head has one.

    Raises `EcfitError` for unknown names and terms that do not fit together.
    """

    structure: Structure = eqx.field(static=True)
    start: tuple[float, ...] = eqx.field(static=True)

    def __init__(
        self,
        head: Any = None,
        features: Sequence[str] = (),
        numerators: Sequence[Any] = (),
        denominator: Any = (),
        start: Sequence[float] = (),
        *,
        structure: Structure | None = None,
    ) -> None:
        if structure is None:
            structure = Structure(head_from(head), tuple(features), tuple(numerators), denominator)
        if len(start) not in (0, structure.count):
            raise EcfitError(f"start needs {structure.count} coefficients, got {len(start)}")
        if not np.all(np.isfinite(np.asarray(start, dtype=np.float64))):
            raise EcfitError("start must be finite numbers")
        self.structure, self.start = structure, tuple(map(float, start))

    @property
    def name(self) -> str:
        return self.structure.head.name

    @property
    def degree(self) -> str:
        return str(self.structure.count)

    def count(self, variables: int) -> int:
        return self.structure.count


class Selected(Form):
    """A structured form whose terms are searched for, within bounds and a number of coefficients.

    Args:
        head, features: as for `Structured`.
        numerators: for each ratio, bounds of its terms (`Powers`, or a mapping of its fields).
        denominator: the same for Q.
        budget: number of coefficients.
        rounds: random exchanges of terms tried.
        seeds: searches, each with a seed of its own; the best is taken.
    """

    whole: Structure = eqx.field(static=True)
    budget: int = eqx.field(static=True)
    rounds: int = eqx.field(static=True)
    seeds: int = eqx.field(static=True)

    def __init__(
        self,
        head: Any,
        features: Sequence[str],
        numerators: Sequence[Any],
        denominator: Any,
        budget: int,
        rounds: int = 100,
        seeds: int = 1,
    ) -> None:
        bounds = [_powers(n) for n in numerators]
        self.whole = candidates(head_from(head), tuple(features), bounds, _powers(denominator))
        for label, value, least in (("budget", budget, 2), ("rounds", rounds, 0), ("seeds", seeds, 1)):
            if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= 100_000:
                raise EcfitError(f"{label} must be an integer >= {least}, got {value!r}")
        if len(self.whole.denominator) < 2:
            raise EcfitError("bounds of the denominator leave one term, its constant: allow more")
        # The search begins with a term of each numerator and a second one of Q.
        if budget < len(self.whole.numerators) + 1:
            raise EcfitError(
                f"head '{self.whole.head.name}' needs a budget of at least {len(self.whole.numerators) + 1}"
            )
        if budget > self.whole.count:
            raise EcfitError(f"the budget is {budget}, but there are only {self.whole.count} candidate terms")
        self.budget, self.rounds, self.seeds = budget, rounds, seeds

    @property
    def name(self) -> str:
        return f"{self.whole.head.name}-selected"

    @property
    def degree(self) -> str:
        return str(self.budget)

    def count(self, variables: int) -> int:
        return self.budget


def _powers(given: Any) -> Powers:
    if isinstance(given, Powers):
        return given
    if not isinstance(given, Mapping):
        raise EcfitError(
            f"bounds of terms must be a table such as {{ highest = {{ mu = 3 }} }}, got {given!r}"
        )
    try:
        return Powers(**given)
    except TypeError:
        known = ", ".join(Powers.__dataclass_fields__)
        raise EcfitError(f"bounds of terms take {known}; got {', '.join(map(str, given))}") from None
