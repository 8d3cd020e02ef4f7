"""Selection of the terms of a structured form on a table: one search a seed, and what the searches found."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecfit.errors import EcfitError
from ecfit.expressions.cost import Cost, cost
from ecfit.fitting.descent import Descent, Rows, Target
from ecfit.fitting.samples import check_coordinates, guard_points, table_points
from ecfit.fitting.search import Found, Search
from ecfit.forms import Structure
from ecfit.forms.candidates import chosen
from ecfit.forms.specified import Selected
from ecfit.tables import Table

# Searches weigh entries by this power of the rule's weights: Gauss rules thin out towards the edges of the
# domain, where the largest errors are, and half-way to even weights lowers those for little in the mean.
_EVENNESS = 0.5
# The first form's Q has two of so many terms of lowest order; so many pairs are tried.
_FIRST, _PAIRS = 40, 12
# Seeds but the first add so many random terms to the first form, so that they grow along other paths.
_RANDOM_TERMS = 4


@dataclass(frozen=True, eq=False)
class Choice:
    """The best form found of some number of coefficients.

    Attributes:
        structure, coefficients: the form.
        rms: weighted RMS residual on the table, in the search's own weights.
        objective: the same with penalties.
    """

    structure: Structure
    coefficients: np.ndarray
    rms: float
    objective: float

    @property
    def count(self) -> int:
        return self.structure.count

    @property
    def cost(self) -> Cost:
        """Operations of an evaluation."""
        return cost(self.structure.expression(self.coefficients))

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back."""
        return {
            "structure": self.structure.to_dict(),
            "coefficients": self.coefficients.tolist(),
            "rms": self.rms,
            "objective": self.objective,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Choice":
        """The inverse of `to_dict`. Raises `EcfitError`, KeyError or TypeError for anything else."""
        return cls(
            Structure.from_dict(data["structure"]),
            np.asarray(data["coefficients"], dtype=np.float64),
            float(data["rms"]),
            float(data["objective"]),
        )


def descent_for(whole: Structure, table: Table, domain: Mapping[str, tuple[float, float]]) -> Descent:
    """The least-squares problem of all candidate terms on a table, guarded on a closed domain.

    Raises `EcfitError` for a table with entries that are not finite or without the form's coordinates.
    """
    if not table.usable.all():
        raise EcfitError("the table has entries that are NaN or infinite: change its axes before fitting")
    check_coordinates(whole.variables, table.axes)
    points, weights = table_points(table)
    guards = guard_points(domain)
    return Descent(
        whole.head,
        Target(Rows(whole.factors(points), whole.data(points)), table.values.ravel(), weights),
        whole.columns(points),
        Rows(whole.held_factors(guards), whole.data(guards)),
        whole.columns(guards),
    )


def evened(descent: Descent) -> Descent:
    """The same problem in the weights of searches."""
    descent.root_w = descent.root_w**_EVENNESS
    descent.root_w /= np.linalg.norm(descent.root_w)
    return descent


def select(
    descent: Descent, form: Selected, seed: int, told: Callable[[list[Choice]], None] | None = None
) -> list[Choice]:
    """One search: the best form of every size up to the largest budget, smallest first.

    Args:
        descent: of the form's candidates, `evened`.
        form: bounds, budgets and rounds.
        seed: of the random changes; 0 grows greedily, others along random paths.
        told: hears of what was found after each budget.
    """

    def operations(support: list[list[int]], leading: int) -> float:
        structure = chosen(form.whole, support, leading)
        return cost(structure.expression(np.full(structure.count, 0.5))).total

    search = Search(descent, operations=operations, price=form.price, rounding=form.rounding)
    rng = np.random.default_rng(seed)
    first = first_form(search)
    for _ in range(_RANDOM_TERMS if seed else 0):
        first = search.with_random_term(first, rng)
    search.grow(first, max(form.budgets) + 1, rng)
    for budget in form.budgets:
        search.explore(budget, rng, form.rounds)
        if told is not None:
            told(choices(form.whole, search))
    return choices(form.whole, search)


def first_form(search: Search) -> Found:
    """The best form of one term a polynomial, from a few starts. Raises `EcfitError` where all fail."""
    descent = search.descent
    count = len(descent.columns)
    # Pairs of terms of Q whose sum stays farthest from 0, corner included.
    columns, guards = (x[-1][:, :_FIRST] for x in (descent.columns, descent.guard_columns))
    guards = guards / columns.mean(axis=0)
    pairs = [(i, j) for i in range(guards.shape[1]) for j in range(guards.shape[1]) if i != j]
    pairs.sort(key=lambda pair: (-float(np.min(guards[:, pair[0]] + guards[:, pair[1]])), pair))
    found: list[Found] = []
    for leading, second in pairs[:_PAIRS]:
        ratio = columns[:, leading].mean() / columns[:, second].mean()
        for size in (0.1, 1.0):
            support = [[0]] * (count - 1) + [[second]]
            made = search.fit(support, leading, np.r_[np.full(count - 1, size), ratio])
            if made is not None:
                found.append(made)
    if not found:
        raise EcfitError("no start of the search has a positive denominator: choose other terms")
    return min(found, key=lambda f: f.objective)


def choices(whole: Structure, search: Search) -> list[Choice]:
    """What a search found, smallest form first."""
    return [
        Choice(chosen(whole, f.support, f.leading), f.coefficients, f.rms, f.objective)
        for _, f in sorted(search.best.items())
    ]


def merged(found: Iterable[Sequence[Choice]]) -> list[Choice]:
    """The best of several searches by size, smallest form first; the first of equals."""
    best: dict[int, Choice] = {}
    for some in found:
        for choice in some:
            old = best.get(choice.count)
            if old is None or choice.objective < old.objective:
                best[choice.count] = choice
    return [best[k] for k in sorted(best)]


def front(found: Sequence[Choice]) -> list[Choice]:
    """Those that no other beats in both error and operations, cheapest first."""
    out: list[Choice] = []
    for choice in sorted(found, key=lambda c: (c.cost.total, c.objective)):
        if not out or choice.objective < out[-1].objective:
            out.append(choice)
    return out
