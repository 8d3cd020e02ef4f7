"""Running a study: tables, then fits, then the report; whatever is finished on disk is not done again."""

import os
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ecfit.approximation import Approximation
from ecfit.approximation.tables import as_lookup, lookup_name
from ecfit.config import StudyConfig, read_config, to_toml
from ecfit.display import grid
from ecfit.errors import EcfitError
from ecfit.files import clear_parts, make_folder, write_text
from ecfit.fitting import Fit
from ecfit.fitting.selection import Choice
from ecfit.metrics import Errors, measure
from ecfit.progress import Progress
from ecfit.quadrature import FINE, STATUS
from ecfit.study.fits import compute_fits, load_fits, missing_fits
from ecfit.study.plan import Plan, make_plan
from ecfit.study.provenance import write_provenance
from ecfit.study.searches import compute_searches, load_searches
from ecfit.study.summary import SEARCH_COLUMNS, SUMMARY_COLUMNS, csv_text, search_rows, summary_rows
from ecfit.tables import Given, Request, Table
from ecfit.workers import Engine, begin_engine, check_workers


@dataclass(frozen=True, eq=False)
class Study:
    """The results of a study.

    Attributes:
        config: the study file, checked.
        folder: `results/<study>`.
        tables: by name.
        fits: table name -> fits, in the order of the file.
        published: table name -> (published approximation or look-up table, its errors there).
        searches: table name -> (form, the best that its searches found of every size).
        seconds: what was computed in this run -> wall seconds; empty for what was found on disk.
    """

    config: StudyConfig
    folder: Path
    tables: dict[str, Table]
    fits: dict[str, list[Fit]]
    published: dict[str, list[tuple[Approximation, Errors]]]
    searches: dict[str, list[tuple[str, list[Choice]]]] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def report(self) -> Path:
        """The report's page."""
        return self.folder / "report.html"

    def __repr__(self) -> str:
        fits = sum(map(len, self.fits.values()))
        return f"<Study {self.config.name}: {len(self.tables)} tables, {fits} fits, in {self.folder}>"

    def __str__(self) -> str:
        lines = [f"study {self.config.name}, report: {self.report}"]
        for name in self.tables:
            lines += [f"table {name}: {line}" for line in self._verdict(name)]
        return "\n".join([*lines, *(f"WARNING: {w}" for w in self.warnings())])

    def _repr_html_(self) -> str:
        rows = [
            (
                name,
                f.approximation.name,
                f.approximation.count,
                f"{f.rmse:.3e}",
                f"{f.max_error:.3e}",
                f.status,
            )
            for name, fits in self.fits.items()
            for f in fits
        ]
        header = ("table", "fit", "coefficients", "RMSE", "largest error", "status")
        verdict = [f"{name}: {line}" for name in self.tables for line in self._verdict(name)]
        return grid(f"Study {self.config.name} in {self.folder}", header, rows, [*verdict, *self.warnings()])

    def _verdict(self, name: str) -> list[str]:
        from ecfit.report.entries import entries
        from ecfit.report.verdict import sentences

        table = self.tables[name]
        return sentences(entries(table, self.fits.get(name, []), self.published.get(name, [])))

    def warnings(self) -> list[str]:
        """Everything that went wrong, loudest first."""
        out = [f"table {t}: {f.warning()}" for t, fits in self.fits.items() for f in fits if not f.ok]
        for name, table in self.tables.items():
            for status, count in table.counts().items():
                if status not in FINE and count:
                    out.append(f"table {name}: {count} of {table.values.size} entries: {STATUS[status]}")
            out += [f"table {name}: {remark}" for remark in table.remarks()]
        return out


def run(
    config: str | Path,
    results: str | Path = "results",
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Study:
    """Run the study of a TOML file and write `results/<study>/`.

    Args:
        config: path of the study file.
        results: folder for all studies; tables are shared in `results/tables`.
        workers: processes that fit at most, a table each; by default the processors that this process may
            use. The results do not depend on it.
        scheduler: the address of a Dask scheduler, "tcp://host:8786", whose workers then search and fit;
            tables are integrated and files written here. See docs/long-sweeps.md.
        progress: told what is going on.

    Finished tables and fits are found by their content hash and kept: running again resumes. Raises
    `EcfitError` for a bad config and for a scheduler that does not answer, before anything is computed, and
    for files that cannot be written.
    """
    check_workers(workers)
    path = Path(config)
    plan = make_plan(read_config(path), path.parent)
    with begin_engine(workers, scheduler) as engine:
        return _run(plan, path.parent, Path(results), engine, progress or Progress())


def _run(plan: Plan, base: Path, results: Path, engine: Engine, tell: Progress) -> Study:
    root = make_folder(results)
    checked = plan.config
    folder = make_folder(root / checked.name)
    for place in (root / "tables", folder, folder / "fits", folder / "searches", folder / "figures"):
        clear_parts(place)
    seconds: dict[str, float] = {}
    write_text(folder / "config.toml", to_toml(_resolved(checked, base, folder)))
    tables = {name: stored_table(r, name, root, seconds, tell) for name, r in plan.requests.items()}
    lookups = {
        name: [stored_table(r, f"{name} as {lookup_name(r.grid)}", root, seconds, tell) for r in requests]
        for name, requests in plan.lookups.items()
    }
    paths = {name: table_path(request, root) for name, request in plan.requests.items()}
    missing = missing_fits(plan, folder)
    needed = {key for fit in missing for key in fit.searches}
    if plan.searches:
        with tell.stage("searches", len(plan.searches)) as advance:
            compute_searches(plan, needed, folder, paths, seconds, advance, engine)
    with tell.stage("fits", len(plan.fits)) as advance:
        compute_fits(plan, folder, paths, seconds, advance, engine)
    study = _assemble(plan, folder, tables, lookups, load_fits(plan, folder), seconds)
    write_provenance(checked.name, folder, tables, computed=bool(seconds or missing))
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
    tables = {name: Table.load(table_path(request, root)) for name, request in plan.requests.items()}
    lookups = {
        name: [Table.load(table_path(request, root)) for request in requests]
        for name, requests in plan.lookups.items()
    }
    return _assemble(plan, folder, tables, lookups, load_fits(plan, folder), {})


def _assemble(
    plan: Plan,
    folder: Path,
    tables: dict[str, Table],
    lookups: dict[str, list[Table]],
    fits: dict[str, list[Fit]],
    seconds: dict[str, float],
) -> Study:
    published = {
        name: [(a, measure(a, tables[name])) for a in (*found, *map(as_lookup, lookups[name]))]
        for name, found in plan.compare.items()
    }
    return Study(plan.config, folder, tables, fits, published, load_searches(plan, folder), seconds)


def _resolved(config: StudyConfig, base: Path, folder: Path) -> dict[str, Any]:
    """The config with all defaults, rerunnable from its place in the results folder."""
    data = config.model_dump(exclude_none=True, by_alias=True)

    def from_there(path: str) -> str:
        return Path(os.path.relpath(base / path, folder)).as_posix()

    data["plugins"] = [from_there(p) if p.endswith(".py") else p for p in config.plugins]
    for table in data["tables"]:
        if "file" in table:
            table["file"] = from_there(table["file"])
    return {key: value for key, value in data.items() if value != []}


def table_path(request: Request | Given, root: Path) -> Path:
    """The file of a request's table in a results folder, shared by its studies."""
    return root / "tables" / f"{request.key}.npz"


def stored_table(
    request: Request | Given, name: str, root: Path, seconds: dict[str, float], tell: Progress
) -> Table:
    """The table of a request, from `root` where it is there; `name` is what progress and timings call it."""
    path = table_path(request, root)
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


def write_results(study: Study) -> None:
    """Write summary, timings, figures and report of a study into its folder."""
    from ecfit.report import write_report

    write_text(
        study.folder / "summary.csv", csv_text(SUMMARY_COLUMNS, summary_rows(study.fits, study.published))
    )
    if study.searches:
        write_text(study.folder / "searches.csv", csv_text(SEARCH_COLUMNS, search_rows(study.searches)))
    if study.seconds:
        rows = [(what, f"{seconds:.3f}") for what, seconds in study.seconds.items()]
        write_text(study.folder / "timings.csv", csv_text(("what", "wall_seconds"), rows))
    write_report(study)
