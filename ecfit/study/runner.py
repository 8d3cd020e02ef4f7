"""Running a study: tables, then fits, then the report; whatever is finished on disk is not done again."""

import csv
import io
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event, Lock
from typing import Any

from ecfit.approximation import Approximation
from ecfit.config import StudyConfig, read_config, to_toml
from ecfit.errors import EcfitError
from ecfit.files import make_folder, read_json, write_json, write_text
from ecfit.fitting import Fit, Fitter
from ecfit.metrics import Errors, measure
from ecfit.quadrature import STATUS, Status
from ecfit.study.plan import Plan, PlannedFit, make_plan
from ecfit.tables import Table
from ecfit.tables.tabulate import versions

SUMMARY_COLUMNS = (
    "table",
    "form",
    "degree",
    "coefficients",
    "mae",
    "rmse",
    "max_error",
    "min_denominator",
    "status",
    "max_error_at",
    "furnace_mean",
    "furnace_max",
    "prediction_low",
    "prediction_high",
    "iterations",
)


@dataclass(frozen=True, eq=False)
class Study:
    """The results of a study.

    Attributes:
        config: the study file, checked.
        folder: `results/<study>`.
        tables: by name.
        fits: table name -> fits, in the order of the file.
        published: table name -> (published approximation, its errors there).
        seconds: what was computed in this run -> wall seconds; empty for what was found on disk.
    """

    config: StudyConfig
    folder: Path
    tables: dict[str, Table]
    fits: dict[str, list[Fit]]
    published: dict[str, list[tuple[Approximation, Errors]]]
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def report(self) -> Path:
        """The report's page."""
        return self.folder / "report.html"

    def warnings(self) -> list[str]:
        """Everything that went wrong, loudest first."""
        out = [f"table {t}: {f.warning()}" for t, fits in self.fits.items() for f in fits if not f.ok]
        for name, table in self.tables.items():
            for status, count in table.counts().items():
                if status != Status.CONVERGED and count:
                    out.append(f"table {name}: {count} of {table.values.size} entries: {STATUS[status]}")
        return out


class Progress:
    """What a run tells while it works; this one says nothing. The command line shows bars."""

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        """A stage of `total` steps; the yielded function advances it."""
        yield lambda steps: None


def run(config: str | Path, results: str | Path = "results", *, progress: Progress | None = None) -> Study:
    """Run the study of a TOML file and write `results/<study>/`.

    Args:
        config: path of the study file.
        results: folder for all studies; tables are shared in `results/tables`.
        progress: told what is going on.

    Finished tables and fits are found by their content hash and kept: running again resumes. Raises
    `EcfitError` for a bad config, before anything is computed, and for files that cannot be written.
    """
    path = Path(config)
    checked = read_config(path)
    plan = make_plan(checked, path.parent)
    root = make_folder(Path(results))
    folder = make_folder(root / checked.name)
    tell = progress or Progress()
    seconds: dict[str, float] = {}
    write_text(folder / "config.toml", to_toml(_resolved(checked, path.parent, folder)))
    tables = {name: _table(plan, name, root, seconds, tell) for name in plan.requests}
    fits = _fits(plan, folder, tables, seconds, tell)
    study = _assemble(plan, folder, tables, fits, seconds)
    write_results(study)
    return study


def load(config: str | Path, results: str | Path = "results") -> Study:
    """The finished study of a TOML file, from disk, computing nothing.

    Raises `EcfitError` where a table or fit is missing.
    """
    path = Path(config)
    checked = read_config(path)
    plan = make_plan(checked, path.parent)
    root, folder = Path(results), Path(results) / checked.name
    tables: dict[str, Table] = {}
    for name, request in plan.requests.items():
        tables[name] = Table.load(root / "tables" / f"{request.key}.npz")
    fits: dict[str, list[Fit]] = {name: [] for name in plan.requests}
    for planned in plan.fits:
        found = _stored_fit(planned, folder)
        if found is None:
            raise EcfitError(f"fit '{planned.label}' is missing in '{folder}': run the study first")
        fits[planned.table].append(found)
    return _assemble(plan, folder, tables, fits, {})


def _assemble(
    plan: Plan, folder: Path, tables: dict[str, Table], fits: dict[str, list[Fit]], seconds: dict[str, float]
) -> Study:
    published = {
        name: [(a, measure(a, tables[name])) for a in approximations]
        for name, approximations in plan.compare.items()
    }
    return Study(plan.config, folder, tables, fits, published, seconds)


def _resolved(config: StudyConfig, base: Path, folder: Path) -> dict[str, Any]:
    """The config with all defaults, rerunnable from its place in the results folder."""
    data = config.model_dump(exclude_none=True)
    data["plugins"] = [
        Path(os.path.relpath(base / p, folder)).as_posix() if p.endswith(".py") else p for p in config.plugins
    ]
    return {key: value for key, value in data.items() if value != []}


def _table(plan: Plan, name: str, root: Path, seconds: dict[str, float], tell: Progress) -> Table:
    request = plan.requests[name]
    path = root / "tables" / f"{request.key}.npz"
    if path.exists():
        try:
            table = Table.load(path)
            if table.provenance.get("key") == request.key and table.grid.shape == request.grid.shape:
                return table
        except EcfitError:
            pass  # damaged: computed again and replaced
    started = time.perf_counter()
    with tell.stage(f"table {name}", request.grid.size) as advance:
        table = request.compute(advance)
    table.save(path)
    seconds[f"table {name}"] = time.perf_counter() - started
    return table


def _fit_path(planned: PlannedFit, folder: Path) -> Path:
    return folder / "fits" / f"{planned.label}.json"


def _stored_fit(planned: PlannedFit, folder: Path) -> Fit | None:
    """The fit on disk, where it is the planned one."""
    path = _fit_path(planned, folder)
    if not path.exists():
        return None
    try:
        data = read_json(path)
        return Fit.from_dict(data, f"'{path}'") if data.get("key") == planned.key else None
    except (EcfitError, AttributeError):
        return None  # damaged: computed again and replaced


def _fits(
    plan: Plan, folder: Path, tables: dict[str, Table], seconds: dict[str, float], tell: Progress
) -> dict[str, list[Fit]]:
    """All fits by table, in the order of the file; tables are fitted side by side."""
    planned = {name: [f for f in plan.fits if f.table == name] for name in plan.requests}
    lock, stopped = Lock(), Event()
    with tell.stage("fits", len(plan.fits)) as advance:

        def finished(what: str, elapsed: float | None) -> None:
            with lock:
                if elapsed is not None:
                    seconds[what] = elapsed
                advance(1)

        def one_table(name: str) -> list[Fit]:
            fitter = Fitter(tables[name])
            out = []
            for item in planned[name]:
                if stopped.is_set():
                    break
                fit = _stored_fit(item, folder)
                started, computed = time.perf_counter(), fit is None
                if fit is None:
                    fit = _fit(fitter, item, folder)
                out.append(fit)
                finished(f"fit {item.label}", time.perf_counter() - started if computed else None)
            return out

        # Threads: the solver runs outside Python's lock, and compiled functions are shared.
        with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
            try:
                return dict(zip(planned, pool.map(one_table, planned), strict=True))
            finally:
                # After an interrupt or an error: no thread begins another fit.
                stopped.set()


def _fit(fitter: Fitter, planned: PlannedFit, folder: Path) -> Fit:
    """Compute one fit and write its file."""
    try:
        fit = fitter.fit(planned.form)
    except EcfitError as error:
        raise EcfitError(f"fit '{planned.label}': {error}") from None
    provenance = {**versions(), "table": str(fitter.table.provenance.get("key", ""))}
    write_json(_fit_path(planned, folder), {"key": planned.key, **fit.to_dict(), "provenance": provenance})
    return fit


def write_results(study: Study) -> None:
    """Write summary, timings, provenance, figures and report of a study into its folder."""
    from ecfit.report import write_report

    write_text(study.folder / "summary.csv", _csv(SUMMARY_COLUMNS, _summary_rows(study)))
    if study.seconds:
        rows = [(what, f"{seconds:.3f}") for what, seconds in study.seconds.items()]
        write_text(study.folder / "timings.csv", _csv(("what", "wall_seconds"), rows))
    write_json(study.folder / "provenance.json", _provenance(study))
    write_report(study)


def _csv(columns: tuple[str, ...], rows: Any) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def _number(value: float) -> str:
    return f"{value:.6e}"


def _summary_rows(study: Study) -> Iterator[tuple[Any, ...]]:
    for name, fits in study.fits.items():
        for fit in fits:
            yield (
                name,
                fit.approximation.form,
                fit.approximation.degree,
                fit.terms.count,
                *_error_cells(fit.errors),
                _number(fit.smallest.value),
                fit.status,
                _place(fit.errors),
                _number(fit.errors.furnace_mean),
                _number(fit.errors.furnace_max),
                _number(fit.prediction[0]),
                _number(fit.prediction[1]),
                fit.iterations,
            )
    for name, rows in study.published.items():
        for approximation, errors in rows:
            smallest = approximation.smallest_denominator()
            yield (
                name,
                approximation.name,
                approximation.degree,
                approximation.terms.count,
                *_error_cells(errors),
                _number(smallest.value),
                "published" if smallest.bound > 0.0 else "published, pole",
                _place(errors),
                _number(errors.furnace_mean),
                _number(errors.furnace_max),
                "",
                "",
                "",
            )


def _error_cells(errors: Errors) -> tuple[str, str, str]:
    return _number(errors.mae), _number(errors.rmse), _number(errors.max_error)


def _place(errors: Errors) -> str:
    return " ".join(f"{k}={v:.6g}" for k, v in errors.place.items())


def _provenance(study: Study) -> dict[str, Any]:
    return {
        "study": study.config.name,
        "versions": versions(),
        "tables": {
            name: {"key": table.provenance.get("key", ""), "versions": dict(table.provenance)}
            for name, table in study.tables.items()
        },
    }
