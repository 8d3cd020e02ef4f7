"""`fit`: from a table and a form to coefficients with an honest account of how good they are."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ecfit._jax import jax
from ecfit.approximation import Approximation
from ecfit.coordinates import Grid
from ecfit.errors import EcfitError
from ecfit.files import read_json, write_json
from ecfit.fitting.problem import Problem
from ecfit.fitting.solver import Solution, linear_solution, mean_square, solve
from ecfit.fitting.start import embedded, lifted_start, ones_start, polynomial_start, sanathanan_koerner
from ecfit.forms import Form, Minimum, Terms, smallest_denominator
from ecfit.metrics import Errors, measure, prediction_range
from ecfit.tables import Table

Array = jax.Array

STATUSES = {
    "converged": "the solver converged and the denominator is positive on the whole domain",
    "not-converged": "the solver stopped before it converged",
    "pole": "the denominator vanishes in the domain",
}

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


@dataclass(frozen=True, eq=False)
class Fit:
    """An approximation fitted to a table, with its errors on the table's nodes.

    Attributes:
        approximation: the evaluated form; calling the fit calls it.
        errors: MAE, RMSE, maximum with its place, over all finite entries.
        smallest: minimum of the denominator over the whole domain.
        prediction: (low, high) of the fit on the nodes and on a grid between them.
        status: a name of `STATUSES`.
        iterations: Levenberg-Marquardt steps of the chosen start, all stages.
        starts: number of starts that were tried.
        table_key: key of the table it was fitted to.
    """

    approximation: Approximation
    errors: Errors
    smallest: Minimum
    prediction: tuple[float, float]
    status: str
    iterations: int
    starts: int
    table_key: str = ""

    def __call__(self, **coordinates: Any) -> Array:
        """The value at physical coordinates; see `Approximation.__call__`."""
        return self.approximation(**coordinates)

    @property
    def coefficients(self) -> np.ndarray:
        """Plain-monomial coefficients: numerator, then denominator without its constant 1."""
        return self.approximation.coefficients

    @property
    def terms(self) -> Terms:
        return self.approximation.terms

    @property
    def mae(self) -> float:
        return self.errors.mae

    @property
    def rmse(self) -> float:
        return self.errors.rmse

    @property
    def max_error(self) -> float:
        return self.errors.max_error

    @property
    def ok(self) -> bool:
        """Whether the fit may be used without a second look."""
        return self.status == "converged"

    def warning(self) -> str:
        """One line that says what is wrong, or nothing."""
        if self.status == "pole":
            place = ", ".join(
                f"{n} = {v:.4g}"
                for n, v in zip(self.approximation.variables, self.smallest.place, strict=True)
            )
            return (
                f"{self.approximation.name} HAS A POLE: its denominator falls to "
                f"{self.smallest.value:.3g} at {place}; do not use it, try another degree"
            )
        if self.status == "not-converged":
            return f"{self.approximation.name} DID NOT CONVERGE after {self.iterations} steps"
        return ""

    def to_dict(self) -> dict:
        """A JSON-ready dictionary that `from_dict` reads back."""
        return {
            **self.approximation.to_dict(),
            "fit": {
                "table": self.table_key,
                "status": self.status,
                "iterations": self.iterations,
                "starts": self.starts,
                "errors": self.errors.to_dict(),
                "smallest_denominator": {
                    "value": self.smallest.value,
                    "place": list(self.smallest.place),
                    "bound": self.smallest.bound,
                },
                "prediction": list(self.prediction),
            },
        }

    @classmethod
    def from_dict(cls, data: Any, where: str = "fit") -> "Fit":
        """Read what `to_dict` wrote; raises `EcfitError` for anything else."""
        approximation = Approximation.from_dict(data, where)
        try:
            fitted = data["fit"]
            if fitted["status"] not in STATUSES:
                raise EcfitError(f"{where}: unknown status '{fitted['status']}'")
            smallest = fitted["smallest_denominator"]
            return cls(
                approximation,
                Errors.from_dict(fitted["errors"]),
                Minimum(
                    float(smallest["value"]), tuple(map(float, smallest["place"])), float(smallest["bound"])
                ),
                _range(fitted["prediction"]),
                fitted["status"],
                int(fitted["iterations"]),
                int(fitted["starts"]),
                str(fitted["table"]),
            )
        except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
            raise EcfitError(f"{where}: malformed fit ({type(error).__name__}: {error})") from None

    def save(self, path: str | Path) -> None:
        """Write JSON."""
        write_json(Path(path), self.to_dict())

    @classmethod
    def load(cls, path: str | Path) -> "Fit":
        """Read JSON written by `save`; raises `EcfitError` for anything else."""
        return cls.from_dict(read_json(Path(path)), f"'{path}'")


def _range(ends: Any) -> tuple[float, float]:
    """(low, high) from JSON, where null stands for infinity."""
    low, high = ends
    return (-np.inf if low is None else float(low), np.inf if high is None else float(high))


class Fitter:
    """Fits forms to one table, and remembers the solutions: each is a start for the next larger form."""

    def __init__(self, table: Table, max_steps: int | None = None) -> None:
        if not isinstance(table, Table):
            raise EcfitError(f"fit expects a Table, got {type(table).__name__}")
        self.table = table
        self.max_steps = max_steps
        self._solved: dict[tuple[str, str], tuple[Problem, Solution, int]] = {}

    def fit(self, form: Form, name: str | None = None) -> Fit:
        """See `ecfit.fit`."""
        if not isinstance(form, Form):
            raise EcfitError(
                f"fit expects a form such as ecfit.Rational(degree=3), got {type(form).__name__}"
            )
        table, label = self.table, name or f"{form.name} {form.degree}"
        terms = form.terms(len(table.axes))
        _check_finite(table)
        check_data(table.grid, form)
        problem = Problem.of_table(table, terms)
        if form.linear:
            solution, steps, tried = linear_solution(problem), 1, 1
        else:
            _, solution, steps, tried = self.descend(form)
        approximation, smallest = self._in_monomials(solution, problem, form, label)
        return Fit(
            approximation,
            measure(approximation, table),
            smallest,
            prediction_range(approximation, table),
            "pole" if smallest.bound <= 0.0 else "converged" if solution.converged else "not-converged",
            steps,
            tried,
            str(table.provenance.get("key", "")),
        )

    def descend(self, form: Form) -> tuple[Problem, Solution, int, int]:
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

    def _search(self, form: Form) -> tuple[Problem, Solution, int]:
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

    def _descend(self, problem: Problem, form: Form) -> list[Solution]:
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
        self, solution: Solution, problem: Problem, form: Form, name: str
    ) -> tuple[Approximation, Minimum]:
        """The solution in plain monomials with its smallest denominator on the domain."""
        coefficients = problem.plain_coefficients(solution.p, solution.q)
        if not np.all(np.isfinite(coefficients)):
            raise EcfitError(
                f"{name}: the best denominator vanishes where all coordinates are 0, so it cannot have the "
                "constant 1; try another degree"
            )
        approximation = Approximation(
            name=name,
            form=form.name,
            degree=form.degree,
            variables=self.table.names,
            terms=problem.terms,
            coefficients=coefficients,
            domain=problem.domain,
            contract=self.table.contract,
        )
        return approximation, approximation.smallest_denominator()


def _pole(problem: Problem, solution: Solution) -> tuple[float, ...] | None:
    """Where the denominator is least, if it may vanish on the domain."""
    coefficients = problem.plain_coefficients(solution.p, solution.q)
    if not np.all(np.isfinite(coefficients)):
        return tuple(low for low, _ in problem.domain)
    found = smallest_denominator(problem.terms, coefficients, problem.domain)
    return None if found.bound > 0.0 else found.place


def fit(table: Table, form: Form, *, name: str | None = None, max_steps: int | None = None) -> Fit:
    """Fit a form to all entries of a table, in the least-squares sense.

    Args:
        table: what to approximate; clamped axes are seen at their nominal coordinates.
        form: `ecfit.Polynomial(degree)`, `ecfit.Rational(degree)`, ...
        name: for reports; made of form and degree by default.
        max_steps: bound on the last Levenberg-Marquardt descent, from the best start; by default 300 to 1000,
            fewer for more coefficients.

    Returns a `Fit`, whose `status` says whether the solver converged and whether the denominator stays
    positive on the domain: look at it. Raises `EcfitError` where the table has too few entries, or entries
    that are not finite.
    """
    return Fitter(table, max_steps).fit(form, name)


def check_data(grid: Grid, form: Form) -> None:
    """Raise `EcfitError` unless a table on `grid` determines the coefficients of `form`."""
    terms = form.terms(len(grid.axes))
    if grid.size < terms.count:
        raise EcfitError(
            f"{form.name} of degree {form.degree} has {terms.count} coefficients, but the table only "
            f"{grid.size} entries: lower the degree or refine the axes"
        )
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
