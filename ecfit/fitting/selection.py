"""Selection of the terms of a structured form on a table: the searches, and what they found."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ecfit.approximation.formula import power_product
from ecfit.errors import EcfitError
from ecfit.fitting.descent import Descent, Rows, Target
from ecfit.fitting.samples import check_coordinates, guard_points, table_points
from ecfit.fitting.search import Found, Search
from ecfit.forms import Structure
from ecfit.forms.candidates import chosen
from ecfit.tables import Table


@dataclass(frozen=True)
class Plan:
    """How hard to search.

    Attributes:
        budgets: numbers of coefficients to spend the time on.
        rounds: random exchanges for each budget and repetition.
        repetitions: of the round over all budgets.
        strength: weight of what exceeds the head's limits.
        seed: of the random exchanges.
    """

    budgets: tuple[int, ...]
    rounds: int = 100
    repetitions: int = 3
    strength: float = 1.0
    seed: int = 0


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


def select(
    descent: Descent,
    plan: Plan,
    start: Found | None = None,
    told: Callable[[Search, int], None] | None = None,
) -> Search:
    """Search the Pareto front up to the largest budget; `told` hears of each budget's round."""
    search = Search(descent, strength=plan.strength)
    first = start or first_form(search)
    rng = np.random.default_rng(plan.seed)
    if plan.seed:  # other seeds grow along other paths
        first = search.randomised(first, rng)
    search.grow(first, max(plan.budgets))
    for _ in range(plan.repetitions):
        for budget in plan.budgets:
            search.explore(budget, rng, plan.rounds)
            search.swap(budget)
            if told is not None:
                told(search, budget)
    return search


def first_form(search: Search) -> Found:
    """The best form of one term a polynomial, from a few starts. Raises `EcfitError` where all fail."""
    descent = search.descent
    count = len(descent.columns)
    found: list[Found] = []
    for leading in range(min(3, descent.columns[-1].shape[1])):
        for second in range(min(8, descent.columns[-1].shape[1])):
            if second == leading:
                continue
            support = [[0]] * (count - 1) + [[second]]
            for size in (0.1, 1.0):
                made = search.fit(support, leading, np.r_[np.full(count - 1, size), 1.0])
                if made is not None:
                    found.append(made)
    if not found:
        raise EcfitError("no start of the search has a positive denominator: choose other terms")
    return min(found, key=lambda f: f.objective)


def structures(whole: Structure, search: Search) -> dict[int, tuple[Structure, np.ndarray, float]]:
    """For each number of coefficients the best structure, its coefficients and weighted RMS."""
    out = {}
    for count, found in sorted(search.best.items()):
        out[count] = chosen(whole, found.support, found.leading), found.coefficients, found.rms
    return out


def to_json(whole: Structure, search: Search) -> list[dict[str, Any]]:
    """What was found, JSON-ready."""
    return [
        {"count": count, "structure": s.to_dict(), "coefficients": c.tolist(), "rms": rms}
        for count, (s, c, rms) in structures(whole, search).items()
    ]


def located(whole: Structure, structure: Structure) -> tuple[list[list[int]], int]:
    """Where a structure's terms are among candidates: support and leading. Raises `EcfitError` if missing."""

    for name in structure.features:
        if name not in whole.features:
            raise EcfitError(
                f"feature '{name}' is not among those of the candidates: {', '.join(whole.features)}"
            )

    def place(exponents: np.ndarray, among: np.ndarray) -> list[int]:
        full = np.zeros((len(exponents), len(whole.features)))
        for i, name in enumerate(structure.features):
            full[:, whole.features.index(name)] = exponents[:, i]
        index = {tuple(row): i for i, row in enumerate(among.tolist())}
        try:
            return [index[tuple(row)] for row in full.tolist()]
        except KeyError as error:
            term = power_product(whole.features, error.args[0])
            raise EcfitError(f"the term {term} is not among the candidates") from None

    pairs = zip(structure.numerators, whole.numerators, strict=True)
    support: list[list[int]] = [place(a, b) for a, b in pairs]
    leading, *rest = place(structure.denominator, whole.denominator)
    return [*support, rest], leading
