"""Fits of structured forms: a start, the norm asked for, and a look for poles on the whole domain."""

import inspect
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ecfit.approximation import Approximation, StructuredFormula
from ecfit.coordinates import viewed
from ecfit.errors import EcfitError, unknown
from ecfit.fitting.descent import Descent, Solved
from ecfit.fitting.monotone import held
from ecfit.fitting.norms import NORMS, solve_in_norm
from ecfit.fitting.result import Fit, judged
from ecfit.fitting.samples import check_coordinates
from ecfit.fitting.selection import Choice, descent_for, evened, merged, select
from ecfit.fitting.watch import watched, weak_points
from ecfit.fitting.weights import entry_weights
from ecfit.forms import Structure, head
from ecfit.forms.specified import Selected, Structured
from ecfit.tables import Table

# The last descent: these forms converge in tens of steps from their start.
_FINAL = {"rtol": 1e-8, "max_steps": 400}
# Where the optimum breaks its limits between the guards, it is guarded there, so often; where the guards do
# not keep Q from vanishing, they weigh this much more.
_ROUNDS, _HARDER = 4, 30.0
# What only descents can hold, no linear program.
_DESCENTS_ONLY = ("ridge", "monotone")
# Arguments of `fit` itself.
_NO_SETTINGS = ("table", "form", "name", "max_steps")
# alpha and mu of a structured form are covered to their closed ends, whatever the table's range.
_CLOSED = {"alpha": (0.0, 1.0), "mu": (0.0, 1.0)}


def domain_of(structure: Structure, table: Table) -> dict[str, tuple[float, float]]:
    """The closed domain of a form fitted to a table: [0, 1] for alpha and mu, the table's for the others."""
    check_coordinates(structure.variables, table.axes)
    return closed_domain(structure.variables, table)


def closed_domain(variables: Sequence[str], table: Table) -> dict[str, tuple[float, float]]:
    """[0, 1] for alpha and mu, the table's range for the others. Raises `EcfitError` where it has none."""
    return {name: _CLOSED.get(name) or table_range(table, name) for name in variables}


def table_range(table: Table, name: str) -> tuple[float, float]:
    """The range of a coordinate on a table, whichever view of it an axis has."""
    for axis in table.axes:
        low, high = (viewed(name, axis.name, end) for end in (axis.low, axis.high))
        if low is not None and high is not None:
            return float(low), float(high)
    raise EcfitError(f"the table has no coordinate {name}")


def fit_structured(
    table: Table,
    form: Structured,
    *,
    name: str | None = None,
    norm: str = "least-squares",
    max_steps: int | None = None,
    digits: int | None = None,
    strength: float = 1.0,
    margin: float = 0.0,
    ridge: float = 0.0,
    weights: Any = None,
    monotone: Mapping[str, int] | None = None,
) -> Fit:
    """Fit a form of given terms; see `ecfit.fit` for the arguments."""
    structure = form.structure
    _check_numbers(digits, strength=strength, margin=margin, ridge=ridge)
    _check_rows(table, structure.count)
    domain = domain_of(structure, table)
    descent = descent_for(structure, table, domain)
    support = [list(range(len(n))) for n in structure.numerators]
    support.append(list(range(1, len(structure.denominator))))
    start = _start(descent, support, form)
    settings: dict[str, Any] = {**_FINAL, "strength": strength, "least": margin, "ridge": ridge}
    if max_steps is not None:
        settings["max_steps"] = max_steps
    measure, extra = _norm(norm), entry_weights(table, weights, structure.count)

    def solve(start: np.ndarray) -> Solved:
        return solve_in_norm(descent, support, 0, start, measure, extra, **settings)

    trial = 1
    while True:
        solved = held(monotone, descent, structure, domain, start, solve) if monotone else solve(start)
        fit = _finished(table, structure, solved, name, digits, starts=trial)
        if not strength or trial > _ROUNDS:
            return fit
        weak = weak_points(structure, fit.coefficients, domain, margin)
        if weak is not None:
            watched(descent, structure, weak)
        # A linear program keeps the limits at the guards: it would be the same again.
        elif fit.status != "pole" or np.isinf(measure.power):
            return fit
        if fit.status == "pole":
            settings["strength"] *= _HARDER
        start = solved.coefficients if descent.least_q(support, 0, solved.coefficients) > 0.0 else start
        trial += 1


def structured_from(approximation: Approximation) -> Structured:
    """A fitted quotient of polynomials as a structured form with its coefficients as the start.

    Raises `EcfitError` where its variables are no features.
    """
    terms, (p, q) = approximation.terms, approximation.terms.split(approximation.coefficients)
    constant = np.zeros((1, terms.variables))
    structure = Structure(
        head("ratio"),
        approximation.variables,
        (terms.numerator.astype(np.float64),),
        np.concatenate([constant, terms.denominator]),
    )
    return Structured(structure=structure, start=tuple(np.concatenate([p, q])))


def fit_selected(
    table: Table,
    form: Selected,
    *,
    name: str | None = None,
    norm: str = "least-squares",
    digits: int | None = None,
    **settings: Any,
) -> Fit:
    """Search the terms of a form, then fit them; see `ecfit.fit` for the arguments."""
    _norm(norm)
    _check_numbers(digits, **{n: settings[n] for n in ("strength", "margin", "ridge") if n in settings})
    entry_weights(table, settings.get("weights"), form.budget)  # told before the search
    found = merged(searched(table, form, seed) for seed in range(form.seeds))
    given = within_budget(form, found)
    return fit_structured(table, given, name=name, norm=norm, digits=digits, **settings)


def searched(table: Table, form: Selected, seed: int) -> list[Choice]:
    """What one of a form's searches finds: the best of every size. Raises `EcfitError` as `ecfit.fit`."""
    _check_rows(table, max(form.budgets))
    descent = evened(descent_for(form.whole, table, domain_of(form.whole, table)))
    return select(descent, form, seed)


def within_budget(form: Selected, found: Sequence[Choice]) -> Structured:
    """The form of the budget among what was found, started at its coefficients.

    Raises `EcfitError` where the searches found none.
    """
    choice = next((c for c in found if c.count == form.budget), None)
    if choice is None:
        raise EcfitError(
            f"the search found no form of {form.budget} coefficients: allow more terms or rounds"
        )
    return Structured(structure=choice.structure, start=tuple(choice.coefficients))


def _norm(name: str) -> Any:
    if name not in NORMS:
        raise unknown("norm", name, NORMS)
    return NORMS[name]


def check_settings(settings: Mapping[str, Any]) -> None:
    """Raise `EcfitError` for settings that no fit of a structured form takes, or not with its norm."""
    known = [n for n in inspect.signature(fit_structured).parameters if n not in _NO_SETTINGS]
    for name in settings:
        if name not in known:
            raise unknown("setting of fit", name, known)
    norm = settings.get("norm", "least-squares")
    if np.isinf(_norm(norm).power):
        for name in _DESCENTS_ONLY:
            if settings.get(name):
                raise EcfitError(
                    f"{name} has no effect in the norm '{norm}', which is a linear program: "
                    f"use the norm 'l8', or leave {name} out"
                )


def _check_numbers(digits: Any, **numbers: Any) -> None:
    whole = isinstance(digits, int) and not isinstance(digits, bool)
    if digits is not None and not (whole and 3 <= digits <= 17):
        raise EcfitError(f"digits must be an integer in 3..17, got {digits!r}")
    for name, value in numbers.items():
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and 0.0 <= value < np.inf):
            raise EcfitError(f"{name} must be a number >= 0, got {value!r}")


def _check_rows(table: Table, count: int) -> None:
    if table.values.size < count:
        raise EcfitError(
            f"the form has {count} coefficients, but the table only {table.values.size} entries: "
            "choose fewer terms or refine the axes"
        )


def _start(descent: Descent, support: list[list[int]], form: Structured) -> np.ndarray:
    starts = [np.array(form.start)] if form.start else []
    linearised = descent.linearised(support, 0)
    if linearised is not None:
        starts.append(linearised)
    if not starts:
        starts.append(np.full(form.structure.count, 0.1))
    return min(starts, key=lambda c: descent.rms(support, 0, c))


def _finished(
    table: Table, structure: Structure, solved: Solved, name: str | None, digits: int | None, starts: int
) -> Fit:
    coefficients = solved.coefficients
    if digits is not None:
        coefficients = np.array([float(f"{c:.{digits}g}") for c in coefficients])
    label = structure.head.name
    ends: Mapping[str, tuple[float, float]] = domain_of(structure, table)
    approximation = Approximation(
        name=name or f"{label} {structure.count}",
        form=label,
        degree=str(structure.count),
        variables=structure.variables,
        formula=StructuredFormula(structure, coefficients),
        domain=tuple(ends[v] for v in structure.variables),
        contract=table.contract,
    )
    return judged(approximation, table, solved.converged, solved.steps, starts)
