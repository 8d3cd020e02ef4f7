"""`fit`: from a table and a form to coefficients with an honest account of how good they are."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import equinox as eqx
import numpy as np

from ecfit.approximation import Approximation
from ecfit.coordinates import Grid
from ecfit.errors import EcfitError
from ecfit.fitting.least import check_bounded, least_max_error
from ecfit.fitting.module_fit import fit_module
from ecfit.fitting.monotone import check_truth, directions
from ecfit.fitting.problem import Problem
from ecfit.fitting.result import Fit, judged
from ecfit.fitting.samples import check_coordinates
from ecfit.fitting.solver import Solution, linear_solution, mean_square, solve
from ecfit.fitting.start import embedded, lifted_start, ones_start, polynomial_start, sanathanan_koerner
from ecfit.fitting.structured import check_settings, fit_selected, fit_structured, structured_from
from ecfit.fitting.weights import check_powers
from ecfit.forms import Form, ModuleForm, Selected, Structured, TermsForm, smallest_denominator
from ecfit.tables import Table

# Nodes an axis of the search for the minimum, and of its last steps. Smooth residuals need few: the RMSE on
# all of 1024 x 1024 nodes is within 0.1 % of its minimum up to degree 7 (docs/performance.md). Smaller tables
# are used whole.
_SEARCH_NODES = {1: 1024, 2: 72, 3: 24}
_POLISH_NODES = {1: 4096, 2: 128, 3: 32}
# A barrier of this part of the start's RMS residual, then a tenth of it, leads round the poles at which a
# plain descent would stop; without effect on the minimum, since the last descent has none. Denominators of
# fewer coefficients than this reach one minimum from every start and need none (conductor, degree 1 to 4).
_BARRIERS = (0.1, 0.01)
_BARRIER_TERMS = 19
# Relative change of coefficients and error at which a descent ends, and its steps at most. The search only
# ranks the starts; flat valleys of high degrees would take thousands of steps for the last digit of the RMSE.
_SEARCH = {"rtol": 1e-4, "max_steps": 300}
_BARRIER = {"rtol": 1e-3, "max_steps": 300}
_FINAL_RTOL = 1e-6
# Steps of the last descent at most, times coefficients: fits of few coefficients may wander along a valley
# for 1000 steps, which would take minutes for many coefficients.
_FINAL_STEPS = 40_000
# Rounds of guarding the place of a pole that was found between the guards.
_WATCHES = 6
# What a fit of a module may be asked for; other forms also take a norm, ...
_MODULE_SETTINGS = ("weights", "digits")


class Fitter:
    """Fits forms to one table, and remembers the solutions: each is a start for the next larger form.

    Args:
        table: what to approximate.
        max_steps: bound on the last descent of each fit, as in `ecfit.fit`.

    Raises `EcfitError` for what is no table.
    """

    def __init__(self, table: Table, max_steps: int | None = None) -> None:
        if not isinstance(table, Table):
            raise EcfitError(f"fit expects a Table, got {type(table).__name__}")
        self.table = table
        self.max_steps = max_steps
        self._solved: dict[tuple[str, str], tuple[Problem, Solution, int]] = {}

    def fit(self, form: Form | eqx.Module, name: str | None = None, **settings: Any) -> Fit:
        """Fit one form; arguments, result and errors (`EcfitError`) are those of `ecfit.fit`."""
        _check_finite(self.table)
        if isinstance(form, eqx.Module) and not isinstance(form, Form) and callable(form):
            form = ModuleForm(form)
        check_asked(form, settings, self.table.names)
        check_truth(settings.get("monotone"), self.table)
        if settings.pop("lower_bound", False):
            found = self.fit(form, name, **settings)
            least = least_max_error(found, self.table, settings.get("margin", 0.0))
            return replace(found, least_max_error=least.error, least_tight=least.tight)
        if isinstance(form, ModuleForm):
            return fit_module(self.table, form, name=name, max_steps=self.max_steps, **settings)
        if isinstance(form, Structured):
            return fit_structured(self.table, form, name=name, max_steps=self.max_steps, **settings)
        if isinstance(form, Selected):
            return fit_selected(self.table, form, name=name, max_steps=self.max_steps, **settings)
        if not isinstance(form, TermsForm):
            raise EcfitError(
                "fit expects a form such as ecfit.Rational(degree=3), or an equinox.Module with __call__, "
                f"got {type(form).__name__}"
            )
        check_data(self.table.grid, form)
        found = self._fit_terms(form, name)
        if not settings:
            return found
        # Other norms than least squares begin from its solution.
        given = structured_from(found.approximation)
        label = name or found.approximation.name
        return fit_structured(self.table, given, name=label, max_steps=self.max_steps, **settings)

    def _fit_terms(self, form: TermsForm, name: str | None) -> Fit:
        table, label = self.table, name or f"{form.name} {form.degree}"
        problem = Problem.of_table(table, form.terms(len(table.axes)))
        if form.linear:
            solution, steps, tried = linear_solution(problem), 1, 1
        else:
            _, solution, steps, tried = self.descend(form)
        approximation = self._in_monomials(solution, problem, form, label)
        return judged(approximation, table, solution.converged, steps, tried)

    def descend(self, form: TermsForm) -> tuple[Problem, Solution, int, int]:
        """The thinned problem, its minimum from the best start, steps, and number of starts.

        For forms with a denominator; `fit` judges the solution on the whole table.
        """
        found, solution, tried = self._search(form)
        whole = Problem.of_table(self.table, form.terms(len(self.table.axes)))
        fine = replace(whole.thinned(_POLISH_NODES.get(whole.terms.variables, 12)), watched=found.watched)
        guarded = not form.may_have_poles
        steps = solution.steps
        most = self.max_steps or max(300, _FINAL_STEPS // whole.terms.count)
        for _ in range(_WATCHES):
            start = solution.p, solution.q
            final = solve(fine, start, rtol=_FINAL_RTOL, max_steps=most, guarded=guarded)
            steps += final.steps
            place = _pole(fine, final) if guarded else None
            if place is None:
                return fine, final, steps, tried
            # The descent found a pole between the guards: watch the place and descend again.
            fine = fine.watching(place)
        return fine, solution, steps, tried

    def _search(self, form: TermsForm) -> tuple[Problem, Solution, int]:
        """The best solution of several starts on a thinned table, the problem, and the number of starts."""
        key = (form.name, form.degree)
        if key not in self._solved:
            problem = Problem.of_table(self.table, form.terms(len(self.table.axes)))
            problem = problem.thinned(_SEARCH_NODES.get(problem.terms.variables, 10))
            found = self._linear(problem) if form.linear else self._descend(problem, form)
            guarded = not form.may_have_poles

            def rank(entry: Solution) -> tuple[bool, float]:
                return guarded and _pole(problem, entry) is not None, entry.sum_of_squares

            tried = len(found)
            for _ in range(_WATCHES):
                best = min(found, key=lambda entry: entry.sum_of_squares)
                place = _pole(problem, best) if guarded else None
                if place is None:
                    break
                # The best has a pole between the guards: near it there are minima without one.
                problem = problem.watching(place)
                found = [entry for entry in found if entry is not best]
                starts = [polynomial_start(problem), *lifted_start(problem)]
                found += [self._around_poles(problem, start) for start in starts]
                tried += len(starts)
            best = min(found, key=rank)
            self._solved[key] = problem, best, tried
        return self._solved[key]

    def _linear(self, problem: Problem) -> list[Solution]:
        return [linear_solution(problem)]

    def _descend(self, problem: Problem, form: TermsForm) -> list[Solution]:
        """Levenberg-Marquardt from every start that there is."""
        guarded = not form.may_have_poles
        starts = [*sanathanan_koerner(problem, guarded), polynomial_start(problem)]
        if not guarded:
            starts.append(ones_start(problem))
        coarser = form.coarser()
        found = []
        if guarded:
            found += [self._around_poles(problem, start) for start in lifted_start(problem)]
        if coarser is not None:
            coarse, solution, _ = self._search(coarser)
            start = embedded(problem, coarse, (solution.p, solution.q))
            starts.append(start)
            if guarded and len(problem.terms.denominator) >= _BARRIER_TERMS:
                found.append(self._around_poles(problem, start))
        return found + [solve(problem, start, guarded=guarded, **_SEARCH) for start in starts]

    def _around_poles(self, problem: Problem, start: tuple[np.ndarray, np.ndarray]) -> Solution:
        rms = mean_square(problem, *start) ** 0.5
        for barrier in _BARRIERS:
            solution = solve(problem, start, barrier=barrier * rms, **_BARRIER)
            start = solution.p, solution.q
        return solve(problem, start, **_SEARCH)

    def _in_monomials(
        self, solution: Solution, problem: Problem, form: TermsForm, name: str
    ) -> Approximation:
        """The solution in plain monomials."""
        coefficients = problem.plain_coefficients(solution.p, solution.q)
        if not np.all(np.isfinite(coefficients)):
            raise EcfitError(
                f"{name}: the best denominator vanishes where all coordinates are 0, so it cannot have the "
                "constant 1; try another degree"
            )
        return Approximation.quotient(
            name=name,
            form=form.name,
            degree=form.degree,
            variables=self.table.names,
            terms=problem.terms,
            coefficients=coefficients,
            domain=problem.domain,
            contract=self.table.contract,
        )


def _pole(problem: Problem, solution: Solution) -> tuple[float, ...] | None:
    """Where the denominator is least, if it may vanish on the domain."""
    coefficients = problem.plain_coefficients(solution.p, solution.q)
    if not np.all(np.isfinite(coefficients)):
        return tuple(low for low, _ in problem.domain)
    found = smallest_denominator(problem.terms, coefficients, problem.domain)
    return None if found.bound > 0.0 else found.place


def fit(
    table: Table,
    form: Form | eqx.Module,
    *,
    name: str | None = None,
    max_steps: int | None = None,
    **settings: Any,
) -> Fit:
    """Fit a form to all entries of a table.

    Args:
        table: what to approximate; clamped axes are seen at their nominal coordinates.
        form: `ecfit.Polynomial(degree)`, `ecfit.Rational(degree)`, `ecfit.Structured(...)`, ..., or any
            Equinox module that is called with the coordinates (see `ecfit.forms.ModuleForm`).
        name: for reports; made of form and degree by default.
        max_steps: bound on the last Levenberg-Marquardt descent, from the best start; by default 300 to 1000,
            fewer for more coefficients.
        settings: for any norm but least squares over equal weights:

            - norm: a name of `ecfit.fitting.NORMS` ("least-squares", "l1", "minimax", "furnace-mean", ...);
            - weights: of the entries in the norm's mean, an array of the table's shape, or coordinate ->
              power ({"mu": 1} weights with mu); maximum norms only leave out entries of weight 0;
            - digits: significant digits that the coefficients are rounded to;
            - strength: weight of the penalties, at guards over the closed domain, that keep Q > 0 and, for
              heads with a deficit or surplus, E <= 1 or E >= 0. With 0 the optimum may have poles.
              Maximum norms keep to the limits at the guards whatever the strength;
            - margin: how far within its limits the form is held, in units of deficit and surplus (1 - E and E
              over their known factors), so that a certificate can prove them;
            - ridge: weight of the size of the coefficients, for norms that are no maximum;
            - monotone: {coordinate: 1 or -1} where the fit should not fall, or not rise, along it: a
              penalty on a grid over the domain, not a proof, for norms that are no maximum;
            - lower_bound: whether to compute the least possible largest error of the form too, for
              polynomial, rational and structured forms of one ratio (`Fit.least_max_error`; extra `minimax`).
            - Equinox modules take weights and digits.

    Returns a `Fit`, whose `status` says whether the solver converged and whether the denominator stays
    positive on the domain: look at it. Raises `EcfitError` where the table has too few entries, or entries
    that are not finite.
    """
    return Fitter(table, max_steps).fit(form, name, **settings)


def check_asked(form: Any, settings: Mapping[str, Any], axes: Sequence[str]) -> None:
    """Raise `EcfitError` for settings that `ecfit.fit` does not know for a form on a table of such axes."""
    rest = {key: value for key, value in settings.items() if key != "lower_bound"}
    check_settings(rest)
    check_bounded(form, settings.get("lower_bound", False))
    for key in rest:
        if isinstance(form, ModuleForm) and key not in _MODULE_SETTINGS:
            raise EcfitError(
                f"{key} is for forms with terms: a module is fitted by least squares and takes "
                f"{' and '.join(_MODULE_SETTINGS)}"
            )
    if isinstance(settings.get("weights"), Mapping):
        check_powers(settings["weights"], axes)
    directions(settings.get("monotone"), axes)


def check_data(grid: Grid, form: Form) -> None:
    """Raise `EcfitError` unless a table on `grid` determines the coefficients of `form`."""
    count = form.count(len(grid.axes))
    if grid.size < count:
        raise EcfitError(
            f"{form.name} of degree {form.degree} has {count} coefficients, but the table only "
            f"{grid.size} entries: lower the degree or refine the axes"
        )
    if isinstance(form, Structured | Selected):
        check_coordinates(
            (form.structure if isinstance(form, Structured) else form.whole).variables, grid.axes
        )
    if not isinstance(form, TermsForm):
        return
    terms = form.terms(len(grid.axes))
    for v, axis in enumerate(grid.axes):
        highest = int(max(terms.numerator[:, v].max(), terms.denominator[:, v].max(initial=0)))
        if highest >= len(axis):
            raise EcfitError(
                f"{form.name} of degree {form.degree} needs more than {highest} nodes on axis '{axis.name}', "
                f"which has {len(axis)}: lower the degree or refine the axis"
            )


def _check_finite(table: Table) -> None:
    bad = int(np.count_nonzero(~table.usable))
    if bad:
        raise EcfitError(
            f"the table has {bad} of {table.values.size} entries that are NaN or infinite: "
            "change its axes so that they are finite before fitting"
        )
