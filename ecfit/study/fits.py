"""The fits of a study: one file each, computed by worker processes, a table each."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ecfit._versions import versions
from ecfit.approximation.compose import compose
from ecfit.errors import EcfitError
from ecfit.files import Carried, read_json
from ecfit.fitting import Fit, Fitter
from ecfit.fitting.result import judged
from ecfit.fitting.structured import closed_domain, within_budget
from ecfit.forms import Composition, Selected
from ecfit.study.plan import Plan, PlannedFit
from ecfit.study.plugins import load_read
from ecfit.study.searches import found_for
from ecfit.tables import Table
from ecfit.workers import Engine, keep, run_tasks, shared, tell


def fit_path(planned: PlannedFit, folder: Path) -> Path:
    """The file of a fit in a study's folder."""
    return folder / "fits" / f"{planned.label}.json"


def stored_fit(planned: PlannedFit, folder: Path) -> Fit | None:
    """The fit on disk, where it is the planned one."""
    path = fit_path(planned, folder)
    if not path.exists():
        return None
    try:
        data = read_json(path)
        return Fit.from_dict(data, f"'{path}'") if data.get("key") == planned.key else None
    except (EcfitError, AttributeError):
        return None  # damaged: computed again and replaced


def missing_fits(plan: Plan, folder: Path) -> list[PlannedFit]:
    """The fits of a plan that are not on disk."""
    return [planned for planned in plan.fits if stored_fit(planned, folder) is None]


def load_fits(plan: Plan, folder: Path) -> dict[str, list[Fit]]:
    """All fits of a finished study by table, in the order of the file; `EcfitError` where one is missing."""
    fits: dict[str, list[Fit]] = {name: [] for name in plan.requests}
    for planned in plan.fits:
        found = stored_fit(planned, folder)
        if found is None:
            raise EcfitError(f"fit '{planned.label}' is missing in '{folder}': run the study first")
        fits[planned.table].append(found)
    return fits


@dataclass(frozen=True)
class TableFits:
    """A task of a worker: forms to fit to one table, in order, since each helps the next larger one.

    It has all that it needs with it, so that the worker may be a machine without our disks.
    """

    table: Carried
    folder: Path
    fits: tuple[PlannedFit, ...]
    cost: float


def compute_fits(
    plan: Plan,
    folder: Path,
    tables: Mapping[str, Path],
    seconds: dict[str, float],
    advance: Callable[[int], None],
    engine: Engine,
) -> None:
    """Compute the fits that are not on disk yet, tables side by side.

    Args:
        plan: the study.
        folder: of its results.
        tables: files of its tables, by name.
        seconds: given `fit label` -> wall seconds of what was computed.
        advance: called with the number of fits that were found or finished since the last call.
        engine: does them.

    Raises `EcfitError` as `ecfit.fit` does; other fits keep their files.
    """
    missing = missing_fits(plan, folder)
    tasks = []
    for name, path in tables.items():
        own = [planned for planned in missing if planned.table == name]
        fits = tuple(_chosen(f, folder) for f in own if not isinstance(f.form, Composition))
        if fits:
            tasks.append(
                TableFits(Carried(path), folder, fits, _cost(fits, len(plan.requests[name].grid.axes)))
            )
    took: dict[str, float] = {}
    told: set[str] = set()
    advance(len(plan.fits) - len(missing))

    def heard(message: tuple[str, float | None]) -> None:
        label, spent = message
        if spent is not None:
            took[label] = spent
        if label not in told:  # a task that is done again tells again
            told.add(label)
            advance(1)

    run_tasks(
        _fit_table,
        tasks,
        engine=engine,
        costs=[task.cost for task in tasks],
        names=[f"fits of table '{task.fits[0].table}'" for task in tasks],
        heard=heard,
        prepare=partial(load_read, plan.plugins),
    )
    for planned in missing:
        if isinstance(planned.form, Composition):
            _compose(planned, planned.form, plan, folder, Table.load(tables[planned.table]))
            advance(1)
    seconds |= {f"fit {f.label}": took[f.label] for f in missing if f.label in took}


def _compose(planned: PlannedFit, form: Composition, plan: Plan, folder: Path, table: Table) -> None:
    """Put a form together from fits that are on disk, and judge it on its table."""
    named = {other.name: other for other in plan.fits}
    parts = {name: stored_fit(named[fit], folder) for name, fit in form.parts}
    known = {name: fit for name, fit in parts.items() if fit is not None}
    try:
        approximations = {name: fit.approximation for name, fit in known.items()}
        names = dict.fromkeys(v for a in approximations.values() for v in a.variables)
        within = closed_domain(tuple(names), table)
        whole = compose(str(planned.name), form.text, approximations, table.contract, within)
        whole.nodes_of({axis.name: axis.nominal for axis in table.axes})
    except EcfitError as error:
        raise EcfitError(f"fit '{planned.label}': {error}") from None
    _write(planned, judged(whole, table, all(f.ok for f in known.values()), 0, 0), table, folder)


def _cost(fits: tuple[PlannedFit, ...], variables: int) -> float:
    """A guess at the time: descents work on squares of the number of coefficients; linear fits take none."""
    return float(sum(f.form.count(variables) ** 2 for f in fits if not f.form.linear))


def _fit_table(task: TableFits) -> None:
    """Compute the fits of one table; each is written, then told, as soon as it is finished."""
    fitter = Fitter(Table.from_bytes(task.table.read(), task.table.path))
    for planned in task.fits:
        # Finished already where a worker died over this task, maybe before it told so: its time is not known.
        if shared() and stored_fit(planned, task.folder) is not None:
            tell((planned.label, None))
            continue
        started = time.perf_counter()
        try:
            fit = fitter.fit(planned.form, planned.name, **planned.settings)
        except EcfitError as error:
            raise EcfitError(f"fit '{planned.label}': {error}") from None
        _write(planned, fit, fitter.table, task.folder)
        tell((planned.label, time.perf_counter() - started))


def _chosen(planned: PlannedFit, folder: Path) -> PlannedFit:
    """The fit with the terms that its searches found, where it has any."""
    if not isinstance(planned.form, Selected):
        return planned
    found = found_for(planned, folder)
    try:
        return replace(planned, form=within_budget(planned.form, found))
    except EcfitError as error:
        raise EcfitError(f"fit '{planned.label}': {error}") from None


def _write(planned: PlannedFit, fit: Fit, table: Table, folder: Path) -> None:
    provenance = {**versions(), "table": str(table.provenance.get("key", ""))}
    keep(fit_path(planned, folder), {"key": planned.key, **fit.to_dict(), "provenance": provenance})
