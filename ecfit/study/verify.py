"""Whether the files of a finished study still say the truth: a sample of it is computed again.

Tables need not be there (they are not committed): their entries are integrated afresh, and the stored
coefficients are evaluated against them.
"""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ecfit.config import read_config
from ecfit.coordinates import Grid
from ecfit.errors import EcfitError
from ecfit.files import read_json, read_text
from ecfit.fitting import Fit, Fitter
from ecfit.forms import Composition, Selected
from ecfit.metrics import measure, prediction_range
from ecfit.study.fits import fit_path
from ecfit.study.plan import Plan, PlannedFit, make_plan
from ecfit.study.provenance import config_hash
from ecfit.study.runner import table_path
from ecfit.study.summary import SUMMARY_COLUMNS, summary_row
from ecfit.tables import Given, Request, Table
from ecfit.tables.scattered import integrate

# Columns of `summary.csv` that older results lack.
_LATER_COLUMNS = frozenset({"max_over_least"})

# Rounding of a fit's value on another machine: its coefficients may be 1e3 times as large as its value.
_ROUNDING = 1e-12
# Errors of a whole table may move by its own tolerance, and their last printed digits by rounding.
_DIGITS = 1e-6
# A fit made again, on another machine, may stop a step of the solver earlier: RMSE within this part.
_SAME_RMSE = 1e-3


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at, what was found, and whether the study's claim holds."""

    what: str
    text: str
    holds: bool

    def __str__(self) -> str:
        return f"  {'holds' if self.holds else 'FAILS'}  {self.what}: {self.text}"


@dataclass(frozen=True)
class Verification:
    """What `verify` found; true where every claim holds.

    Attributes:
        folder: of the study.
        findings: in the order of the study.
        remarks: what is no fault but should be known, such as results of an older version.
    """

    folder: Path
    findings: tuple[Finding, ...]
    remarks: tuple[str, ...]

    def __bool__(self) -> bool:
        return all(f.holds for f in self.findings)

    def describe(self) -> list[str]:
        """Lines for people; the verdict is the last."""
        failed = sum(not f.holds for f in self.findings)
        verdict = (
            f"{failed} of {len(self.findings)} claims FAIL" if failed else f"all {len(self.findings)} hold"
        )
        remarks = [f"  note   {remark}" for remark in self.remarks]
        return [f"{self.folder}", *map(str, self.findings), *remarks, verdict]


def verify(folder: str | Path, *, entries: int = 1024, refits: int = 1, seed: int = 1) -> Verification:
    """Compute a sample of a study again and compare it with what its folder holds.

    Args:
        folder: of the study, such as `results/quick`, as `run` wrote it.
        entries: nodes of each table that are integrated again, drawn at random; tables that have no more are
            integrated whole, and then all errors of their fits are measured again.
        refits: fits that are made again from tables that were integrated whole, drawn at random.
        seed: of what is drawn.

    Every fit is judged at the drawn nodes and at the place of its largest error, whatever `refits` is.
    Plugins that the study's config names are imported. Raises `EcfitError` where the folder holds no study.
    """
    if entries < 1 or refits < 0 or seed < 0:
        raise EcfitError("verify needs entries >= 1, refits >= 0 and seed >= 0")
    folder = Path(folder)
    plan = make_plan(read_config(folder / "config.toml"), folder)
    draw = np.random.default_rng(seed)
    findings, remarks = _records(plan, folder)
    fits: list[tuple[PlannedFit, Fit]] = []
    older = 0
    for planned in plan.fits:
        try:
            data = read_json(fit_path(planned, folder))
            fits.append((planned, Fit.from_dict(data, f"'{fit_path(planned, folder)}'")))
        except EcfitError as error:
            findings.append(Finding(f"fit {planned.label}", str(error), False))
            continue
        older += data.get("key") != planned.key
    if older:
        remarks.append(
            f"{older} of {len(plan.fits)} fits are of another version: a run would make them again"
        )
    findings += _summary(folder, fits)
    whole: list[tuple[PlannedFit, Fit, Table]] = []
    for name, request in plan.requests.items():
        own = [(planned, fit) for planned, fit in fits if planned.table == name]
        try:
            sample = _sampled(request, [fit for _, fit in own], entries, draw)
        except EcfitError as error:
            findings.append(Finding(f"table {name}", str(error), False))
            continue
        findings.append(_table(name, request, sample, folder.parent))
        for planned, fit in own:
            findings.append(_fit(planned, fit, sample))
        if sample.table is not None:
            whole += [(planned, fit, sample.table) for planned, fit in own]
    findings += _refitted(whole, refits, draw)
    return Verification(folder, tuple(findings), tuple(remarks))


def _records(plan: Plan, folder: Path) -> tuple[list[Finding], list[str]]:
    """Whether provenance and config belong together, and notes of other versions."""
    try:
        data = read_json(folder / "provenance.json")
        tables = {name: str(data["tables"][name]["key"]) for name in plan.requests}
        known = data.get("config")
    except (KeyError, TypeError, AttributeError, EcfitError) as error:
        text = str(error) if isinstance(error, EcfitError) else f"names no {error}"
        return [Finding("provenance.json", text, False)], []
    findings, remarks = [], []
    if known is None:
        remarks.append("provenance.json is of an older version: it has no hash of the config")
    else:
        same = known == config_hash(folder)
        text = "is of this config.toml" if same else "is of another config.toml: one of them was changed"
        findings.append(Finding("provenance.json", text, same))
    for name, request in plan.requests.items():
        if tables[name] == request.key:
            continue
        if isinstance(request, Given):
            findings.append(Finding(f"table {name}", "the file that it was read from has changed", False))
        else:
            remarks.append(f"table {name} is of another version: a run would integrate it again")
    return findings, remarks


def _summary(folder: Path, fits: list[tuple[PlannedFit, Fit]]) -> Iterator[Finding]:
    """Whether `summary.csv` says what the fits' files say."""
    try:
        reader = csv.DictReader(io.StringIO(read_text(folder / "summary.csv")))
        rows, columns = list(reader), set(reader.fieldnames or ())
    except (EcfitError, csv.Error) as error:
        yield Finding("summary.csv", str(error), False)
        return
    lacking = [name for name in SUMMARY_COLUMNS if name not in columns | _LATER_COLUMNS]
    if lacking:
        yield Finding("summary.csv", f"the column {lacking[0]} is missing", False)
        return
    wrong = []
    for planned, fit in fits:
        cells = dict(zip(SUMMARY_COLUMNS, map(str, summary_row(planned.table, fit)), strict=True))
        if not any(all(row[k] == v for k, v in cells.items() if k in columns) for row in rows):
            wrong.append(planned.label)
    text = f"no row says what the file says of {', '.join(wrong[:3])}{', ...' if len(wrong) > 3 else ''}"
    yield Finding("summary.csv", text if wrong else f"agrees with the files of {len(fits)} fits", not wrong)


@dataclass(frozen=True)
class _Sample:
    """Nodes of a table that were integrated again.

    `truth` and `errors` (absolute) are of the nodes `flat` of the grid; `tolerance` is the largest error that
    the stored table may have there. `table` is there where all nodes are.
    """

    request: Request | Given
    flat: np.ndarray
    truth: np.ndarray
    errors: np.ndarray
    tolerance: float
    table: Table | None

    @property
    def grid(self) -> Grid:
        return self.request.grid

    def at(self, flat: int) -> int:
        """Index of a node in the sample."""
        return int(np.flatnonzero(self.flat == flat)[0])


def _sampled(request: Request | Given, fits: list[Fit], entries: int, draw: np.random.Generator) -> _Sample:
    """The drawn nodes and the places of the fits' largest errors, integrated again."""
    grid = request.grid
    if isinstance(request, Given) or grid.size <= entries:
        table = request.compute()
        errors = np.nan_to_num(table.errors.ravel(), nan=0.0)  # of a file: its numbers are the truth
        flat = np.arange(grid.size)
        return _Sample(request, flat, table.values.ravel(), errors, _allowed(request), table)
    drawn = draw.choice(grid.size, entries, replace=False)
    flat = np.unique(np.concatenate([drawn, [_node(grid, fit) for fit in fits]]).astype(np.int64))
    found = integrate(request.contract, grid.nodes_at(flat), min(1e-8, request.tolerance))
    return _Sample(request, flat, found.values, found.errors, _allowed(request), None)


def _allowed(request: Request | Given) -> float:
    """The largest error that an entry of the stored table may have."""
    return 0.0 if isinstance(request, Given) else request.tolerance


def _node(grid: Grid, fit: Fit) -> int:
    """Flat index of the node at which a fit has its largest error."""
    index = []
    for axis in grid.axes:
        if axis.name not in fit.errors.place:
            raise EcfitError(f"the fit {fit.approximation.name} does not say where its largest error is")
        index.append(int(np.argmin(np.abs(axis.nominal - fit.errors.place[axis.name]))))
    return int(np.ravel_multi_index(index, grid.shape))


def _table(name: str, request: Request | Given, sample: _Sample, root: Path) -> Finding:
    """The stored table, where there is one, at the sampled nodes."""
    what, count = f"table {name}", f"{sample.flat.size} of {sample.grid.size} entries integrated again"
    if isinstance(request, Given):
        source = request.table.provenance["source"]
        return Finding(what, f"{sample.grid.size} entries read again from '{source}'", True)
    path = table_path(request, root)
    if not path.exists():
        finite = bool(np.isfinite(sample.truth).all())
        return Finding(what, f"{count}; the table itself is not kept here", finite)
    try:
        stored = Table.load(path)
    except EcfitError as error:
        return Finding(what, str(error), False)
    if stored.grid.shape != sample.grid.shape:
        return Finding(what, f"'{path}' has the shape {stored.grid.shape}", False)
    off = np.abs(stored.values.ravel()[sample.flat] - sample.truth)
    both = stored.errors.ravel()[sample.flat] + sample.errors + _ROUNDING
    bad = ~(off <= both)
    text = f"{count}, at most {off.max():.1e} from the stored"
    if bad.any():
        text += f"; {np.count_nonzero(bad)} differ by more than both error estimates"
    return Finding(what, text, not bad.any())


def _fit(planned: PlannedFit, fit: Fit, sample: _Sample) -> Finding:
    """A fit's stored errors against what its coefficients give at the sampled nodes."""
    what = f"fit {planned.label}"
    try:
        values = np.asarray(fit(**sample.grid.nominal_at(sample.flat)))
    except EcfitError as error:
        return Finding(what, str(error), False)
    off = np.abs(values - sample.truth)
    # Where the tolerance was not met, the stored entry was off by as much as this one.
    slack = sample.tolerance + 2.0 * sample.errors + _ROUNDING + _DIGITS * fit.max_error
    faults = []
    over = off > fit.max_error + slack
    if over.any() or not np.isfinite(values).all():
        faults.append(f"an error of {np.max(off):.3e} where the largest is said to be {fit.max_error:.3e}")
    worst = sample.at(_node(sample.grid, fit))
    if abs(off[worst] - fit.max_error) > slack[worst]:
        faults.append(f"{off[worst]:.3e} at the place of the largest error, said to be {fit.max_error:.3e}")
    least = fit.approximation.smallest_denominator()
    if abs(least.value - fit.smallest.value) > _DIGITS * (1.0 + abs(fit.smallest.value)):
        faults.append(f"the smallest denominator is {least.value:.4g}, said to be {fit.smallest.value:.4g}")
    for new, old in zip(prediction_range(fit.approximation, sample.request), fit.prediction, strict=True):
        if not (new == old or abs(new - old) <= _DIGITS * (1.0 + abs(old))):
            faults.append(f"its values reach {new:.6g}, said to be {old:.6g}")
    text = f"largest error {fit.max_error:.3e} where it is said to be, none above in {off.size} entries"
    if sample.table is not None:
        again = measure(fit.approximation, sample.table)
        for name in ("mae", "rmse"):
            new, old = getattr(again, name), getattr(fit, name)
            if not abs(new - old) <= _DIGITS * old + sample.tolerance:
                faults.append(f"{name.upper()} {new:.6e}, said to be {old:.6e}")
        text += f"; MAE {fit.mae:.3e} and RMSE {fit.rmse:.3e} measured again"
    return Finding(what, "; ".join(faults) or text, not faults)


def _refitted(
    whole: list[tuple[PlannedFit, Fit, Table]], refits: int, draw: np.random.Generator
) -> Iterator[Finding]:
    """Fits made again from their tables, drawn at random; a search of terms would take too long."""
    able = [w for w in whole if not isinstance(w[0].form, Composition | Selected)]
    chosen = sorted(draw.choice(len(able), min(refits, len(able)), replace=False)) if able else []
    for planned, fit, table in (able[i] for i in chosen):
        what = f"fit {planned.label}, made again"
        try:
            again = Fitter(table).fit(planned.form, planned.name, **planned.settings)
        except EcfitError as error:
            yield Finding(what, str(error), False)
            continue
        # Better than said is an older version's fit, not a false claim; worse is one that nobody can repeat.
        worse = again.rmse > (1.0 + _SAME_RMSE) * fit.rmse + _ROUNDING
        yield Finding(what, f"RMSE {again.rmse:.6e}, stored {fit.rmse:.6e}", not worse)
