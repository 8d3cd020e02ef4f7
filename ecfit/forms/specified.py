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
        charted: whether it is evaluated in the corner chart, which keeps half precision from underflowing.

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
        charted: bool = False,
        *,
        structure: Structure | None = None,
    ) -> None:
        if structure is None:
            structure = Structure(head_from(head), tuple(features), tuple(numerators), denominator, charted)
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
        rounds: fits of exchanges tried for each budget.
        seeds: searches, each with a seed of its own; the best is taken.
        price: relative growth of the error that one multiply-add less is worth.
        rounding: what a form may lose in single precision, as estimated from the size of its terms; 0 for no
            limit.
        budgets: all numbers of coefficients that one search is for (the budget by default): forms that
            differ in their budget only share their searches.

    Raises `EcfitError` for unknown names, bounds that leave too few terms for the budget or far too many, and
    numbers outside their ranges (budget >= 2, rounds >= 0, seeds >= 1, price in [0, 1], rounding in [0, 1)).
    """

    whole: Structure = eqx.field(static=True)
    budget: int = eqx.field(static=True)
    rounds: int = eqx.field(static=True)
    seeds: int = eqx.field(static=True)
    price: float = eqx.field(static=True)
    rounding: float | None = eqx.field(static=True)
    budgets: tuple[int, ...] = eqx.field(static=True)

    def __init__(
        self,
        head: Any,
        features: Sequence[str],
        numerators: Sequence[Any],
        denominator: Any,
        budget: int,
        rounds: int = 100,
        seeds: int = 1,
        price: float = 0.0,
        rounding: float = 0.0,
        budgets: Sequence[int] = (),
    ) -> None:
        bounds = [_powers(n) for n in numerators]
        self.whole = candidates(head_from(head), tuple(features), bounds, _powers(denominator))
        numbers = [("budget", b, 2) for b in (budget, *budgets)]
        for label, value, least in (*numbers, ("rounds", rounds, 0), ("seeds", seeds, 1)):
            if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= 100_000:
                raise EcfitError(f"{label} must be an integer >= {least}, got {value!r}")
        if len(self.whole.denominator) < 2:
            raise EcfitError("bounds of the denominator leave one term, its constant: allow more")
        # The search begins with a term of each numerator and a second one of Q.
        least, most = len(self.whole.numerators) + 1, self.whole.count
        for value in (budget, *budgets):
            if value < least:
                raise EcfitError(f"head '{self.whole.head.name}' needs a budget of at least {least}")
            if value > most:
                raise EcfitError(f"the budget is {value}, but there are only {most} candidate terms")
        if isinstance(price, bool) or not isinstance(price, int | float) or not 0.0 <= price <= 1.0:
            raise EcfitError(f"price must be in 0..1, got {price!r}")
        if isinstance(rounding, bool) or not isinstance(rounding, int | float) or not 0.0 <= rounding < 1.0:
            raise EcfitError(f"rounding must be in 0..1, got {rounding!r}")
        self.rounding = float(rounding) or None
        self.budget, self.rounds, self.seeds, self.price = budget, rounds, seeds, float(price)
        self.budgets = tuple(sorted({budget, *budgets}))

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
