"""The searches of a study: one file each, a task of the workers each, so that a killed run resumes."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ecfit._versions import versions
from ecfit.errors import EcfitError
from ecfit.files import Carried, read_json
from ecfit.fitting.selection import Choice, merged
from ecfit.fitting.structured import searched
from ecfit.study.plan import Plan, PlannedFit, PlannedSearch
from ecfit.study.plugins import load_read
from ecfit.tables import Table
from ecfit.workers import Engine, keep, run_tasks


def _path(key: str, folder: Path) -> Path:
    return folder / "searches" / f"{key}.json"


def stored_search(key: str, folder: Path) -> list[Choice] | None:
    """What the search of a key found, where it is on disk."""
    path = _path(key, folder)
    if not path.exists():
        return None
    try:
        return [Choice.from_dict(entry) for entry in read_json(path)["found"]]
    except (EcfitError, AttributeError, KeyError, TypeError, ValueError):
        return None  # damaged: searched again and replaced


def found_for(planned: PlannedFit, folder: Path) -> list[Choice]:
    """The best of a fit's searches by size. Raises `EcfitError` where one is missing."""
    found = []
    for key in planned.searches:
        some = stored_search(key, folder)
        if some is None:
            raise EcfitError(f"the search for fit '{planned.label}' is missing in '{folder}': run the study")
        found.append(some)
    return merged(found)


def load_searches(plan: Plan, folder: Path) -> dict[str, list[tuple[str, list[Choice]]]]:
    """By table: (name of the form, the best of all its searches by size), of the searches on disk."""
    out: dict[str, dict[tuple[str, ...], tuple[str, list[Choice]]]] = {}
    for planned in plan.fits:
        found = [some for key in planned.searches if (some := stored_search(key, folder)) is not None]
        if found:
            out.setdefault(planned.table, {})[planned.searches] = planned.form.name, merged(found)
    return {table: list(rows.values()) for table, rows in out.items()}


@dataclass(frozen=True)
class _Task:
    table: Carried
    folder: Path
    search: PlannedSearch


def compute_searches(
    plan: Plan,
    needed: set[str],
    folder: Path,
    tables: Mapping[str, Path],
    seconds: dict[str, float],
    advance: Callable[[int], None],
    engine: Engine,
) -> None:
    """Compute the searches of the keys `needed` that are not on disk yet, side by side.

    The other arguments are those of `compute_fits`. Raises `EcfitError` where no search can begin.
    """
    missing = [s for s in plan.searches if s.key in needed and stored_search(s.key, folder) is None]
    advance(len(plan.searches) - len(missing))

    def finished(index: int, took: float) -> None:
        seconds[f"search {missing[index].label}"] = took
        advance(1)

    run_tasks(
        _search,
        [_Task(Carried(tables[search.table]), folder, search) for search in missing],
        engine=engine,
        costs=[float(sum(s.form.budgets) * (1 + s.form.rounds)) for s in missing],
        names=[f"search {search.label}" for search in missing],
        finished=finished,
        prepare=partial(load_read, plan.plugins),
    )


def _search(task: _Task) -> float:
    started = time.perf_counter()
    planned = task.search
    try:
        found = searched(Table.from_bytes(task.table.read(), task.table.path), planned.form, planned.seed)
    except EcfitError as error:
        raise EcfitError(f"search {planned.label}: {error}") from None
    keep(
        _path(planned.key, task.folder),
        {
            "table": planned.table,
            "form": planned.form.name,
            "seed": planned.seed,
            "found": [choice.to_dict() for choice in found],
            "provenance": dict(versions()),
        },
    )
    return time.perf_counter() - started
