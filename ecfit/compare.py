"""`compare`: what changed between two results folders of a study, and whether anything got worse.

Reads only what a run has written (summary.csv, provenance.json, fits/*.json): no JAX, no tables.
"""

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ecfit.errors import EcfitError
from ecfit.files import read_json, read_text

# Errors up to this are rounding: nothing is better or worse.
_ROUNDING = 1e-12
_ERRORS = {
    "mae": "MAE",
    "rmse": "RMSE",
    "max_error": "largest error",
    "furnace_mean": "furnace, mean",
    "furnace_max": "furnace, worst",
}
# From good to bad.
_STATUSES = ("converged", "not-converged", "pole")
# What a fit's file says beside the formula itself.
_BESIDE = ("key", "name", "fit", "provenance", "certificate")

# Columns of names: longer ones push their own line aside, not all.
_WIDTH = 44

WORSE, GONE, BETTER, MOVED, NEW = "WORSE", "GONE", "better", "moved", "new"
# In the order in which they are told.
KINDS = (WORSE, GONE, BETTER, MOVED, NEW)


@dataclass(frozen=True)
class Change:
    """One thing that differs between two runs.

    Attributes:
        kind: one of `KINDS`.
        part: "table", "fit" or "published" (whatever is judged beside the fits).
        name: of the table, the fit's file, or "table: approximation".
        text: what, in words and numbers.
    """

    kind: str
    part: str
    name: str
    text: str


@dataclass(frozen=True)
class Comparison:
    """All changes from `old` to `new`.

    Attributes:
        old, new: the folders.
        versions: "jax 0.10.2 -> 0.10.3" of every package whose version differs.
        changes: by kind, then by part and name.
        same: number of tables, fits and published results in which nothing changed.
        tolerance, coefficients: what counts as a change.
    """

    old: Path
    new: Path
    versions: tuple[str, ...]
    changes: tuple[Change, ...]
    same: int
    tolerance: float
    coefficients: float

    @property
    def worse(self) -> bool:
        """Whether something got worse or is gone."""
        return any(c.kind in (WORSE, GONE) for c in self.changes)

    def describe(self) -> list[str]:
        """Lines for people."""
        lines = [f"{self.old} -> {self.new}"]
        if self.versions:
            lines.append(f"versions: {', '.join(self.versions)}")
        width = min(_WIDTH, max((len(f"{c.part} {c.name}") for c in self.changes), default=0))
        lines += [f"{c.kind:6}  {f'{c.part} {c.name}':{width}}  {c.text}" for c in self.changes]
        counts = [f"{sum(c.kind == kind for c in self.changes)} {kind.lower()}" for kind in KINDS]
        lines.append(
            f"{', '.join(counts)}, {self.same} the same "
            f"(errors to {100 * self.tolerance:g} %, coefficients to {self.coefficients:g} of the largest)"
        )
        return lines


@dataclass(frozen=True)
class _Run:
    """What a run has written: keys of tables, files of fits by name, rows of what is published."""

    folder: Path
    versions: Mapping[str, str]
    tables: Mapping[str, str]
    fits: Mapping[str, Mapping[str, Any]]
    published: Mapping[str, Mapping[str, Any]]


def compare(
    old: str | Path, new: str | Path, *, tolerance: float = 0.01, coefficients: float = 1e-6
) -> Comparison:
    """What changed from the results folder `old` to `new`.

    Args:
        old, new: folders such as `results/paper`.
        tolerance: relative change of an error that is told: up is worse, down is better.
        coefficients: change of a coefficient, in units of the largest of its fit, that is told as moved.

    A fit is worse where one of its errors rose or its status is no longer "converged"; a table, fit or
    published result that is not in `new` is gone. The errors of published approximations cannot get better or
    worse by a fit: a change means that the truth moved, and so they are told as moved.

    Raises `EcfitError` for folders that hold no results, and for tolerances that are not positive.
    """
    for name, value in (("tolerance", tolerance), ("coefficients", coefficients)):
        if not 0.0 < value < math.inf:
            raise EcfitError(f"{name} must be a positive number, got {value}")
    a, b = _read(Path(old)), _read(Path(new))
    changes: list[Change] = []
    same = 0
    for part, before, after in (
        ("table", a.tables, b.tables),
        ("fit", a.fits, b.fits),
        ("published", a.published, b.published),
    ):
        for name in sorted({*before, *after}, key=_natural):
            if name not in after:
                found = [Change(GONE, part, name, f"not in {new}")]
            elif name not in before:
                found = [Change(NEW, part, name, f"not in {old}")]
            else:
                told = _TELL[part](before[name], after[name], tolerance, coefficients)
                found = [Change(kind, part, name, text) for kind, text in told]
            changes += found
            same += not found
    changes.sort(key=lambda c: KINDS.index(c.kind))
    # What only one of them recorded is not known to differ.
    versions = tuple(
        f"{n} {a.versions[n]} -> {b.versions[n]}"
        for n in sorted({*a.versions} & {*b.versions})
        if a.versions[n] != b.versions[n]
    )
    return Comparison(a.folder, b.folder, versions, tuple(changes), same, tolerance, coefficients)


def _read(folder: Path) -> _Run:
    if not (folder / "summary.csv").exists():
        raise EcfitError(f"'{folder}' holds no results of a study: it has no summary.csv")
    provenance = read_json(folder / "provenance.json")
    try:
        tables = {str(n): str(t["key"]) for n, t in provenance["tables"].items()}
        versions = {str(n): str(v) for n, v in provenance["versions"].items()}
    except (KeyError, TypeError, AttributeError):
        raise EcfitError(f"'{folder / 'provenance.json'}' is not what a run writes: run it again") from None
    fits = {path.stem: _fit(path) for path in sorted((folder / "fits").glob("*.json"))}
    return _Run(folder, versions, tables, fits, _published(folder / "summary.csv"))


def _fit(path: Path) -> dict[str, Any]:
    data = read_json(path)
    try:
        errors = {n: _number(data["fit"]["errors"][n]) for n in _ERRORS}
        status = str(data["fit"]["status"])
        formula = {k: v for k, v in data.items() if k not in _BESIDE}
    except (KeyError, TypeError, ValueError, AttributeError):
        raise EcfitError(f"'{path}' is not a fit: delete it and run the study again") from None
    return {"errors": errors, "status": status, "formula": formula}


# How the status begins of what is judged beside fits (`ecfit.approximation.standing`, which loads JAX).
_STANDINGS = ("published", "shipped", "table")


def _published(path: Path) -> dict[str, dict[str, Any]]:
    """Rows of the summary that are no fits of ours, by "table: name"."""
    rows = csv.DictReader(read_text(path).splitlines())
    try:
        return {
            f"{row['table']}: {row['form']}": {
                "errors": {n: _number(row[n]) for n in _ERRORS},
                "status": row["status"],
            }
            for row in rows
            if row["status"].startswith(_STANDINGS)
        }
    except (KeyError, TypeError, ValueError, AttributeError):
        raise EcfitError(f"'{path}' is not a summary that a run writes: run it again") from None


def _number(value: Any) -> float:
    return math.inf if value is None else float(value)


def _tell_table(old: str, new: str, tolerance: float, coefficients: float) -> Iterator[tuple[str, str]]:
    if old != new:
        yield MOVED, f"another request or other numerics: key {old} -> {new}"


def _tell_fit(
    old: Mapping[str, Any], new: Mapping[str, Any], tolerance: float, coefficients: float
) -> Iterator[tuple[str, str]]:
    kinds = {}
    for name, label in _ERRORS.items():
        kind, text = _moved(old["errors"][name], new["errors"][name], tolerance)
        if kind:
            kinds.setdefault(kind, []).append(f"{label} {text}")
    if old["status"] != new["status"]:
        kind = BETTER if _rank(new["status"]) < _rank(old["status"]) else WORSE
        kinds.setdefault(kind, []).insert(0, f"status {old['status']} -> {new['status']}")
    for kind, texts in kinds.items():
        yield kind, ", ".join(texts)
    shape_old, numbers_old = _taken_apart(old["formula"])
    shape_new, numbers_new = _taken_apart(new["formula"])
    if shape_old != shape_new or len(numbers_old) != len(numbers_new):
        yield MOVED, "another form, domain or contract"
        return
    largest = max(map(abs, numbers_old), default=0.0) or 1.0
    change = max((abs(x - y) for x, y in zip(numbers_old, numbers_new, strict=True)), default=0.0) / largest
    if change > coefficients:
        yield MOVED, f"coefficients by {change:.2g} of the largest"


def _rank(status: str) -> int:
    """How bad a status is; one that is unknown here is worse than all."""
    return _STATUSES.index(status) if status in _STATUSES else len(_STATUSES)


def _tell_published(
    old: Mapping[str, Any], new: Mapping[str, Any], tolerance: float, coefficients: float
) -> Iterator[tuple[str, str]]:
    found = [(label, _moved(old["errors"][n], new["errors"][n], tolerance)) for n, label in _ERRORS.items()]
    texts = [f"{label} {text}" for label, (kind, text) in found if kind]
    if old["status"] != new["status"]:
        texts.insert(0, f"status {old['status']} -> {new['status']}")
    if texts:
        yield MOVED, ", ".join(texts)


_TELL: Mapping[str, Any] = {"table": _tell_table, "fit": _tell_fit, "published": _tell_published}


def _moved(old: float, new: float, tolerance: float) -> tuple[str, str]:
    """(kind, text) of a change of an error; empty where it is within the tolerance, or rounding."""
    if old == new or max(abs(old), abs(new)) <= _ROUNDING:
        return "", ""
    if math.isfinite(old) and math.isfinite(new) and abs(new - old) <= tolerance * abs(old):
        return "", ""
    part = f" ({100 * (new / old - 1):+.3g} %)" if math.isfinite(new) and 0.0 < old < math.inf else ""
    # NaN is no improvement on anything.
    return (BETTER if new < old else WORSE), f"{old:.3e} -> {new:.3e}{part}"


def _taken_apart(data: Any) -> tuple[Any, list[float]]:
    """A formula's JSON without its real numbers, and these; integers are exponents and belong to the form."""
    if isinstance(data, float):
        return "number", [data]
    if isinstance(data, Mapping):
        parts = {k: _taken_apart(v) for k, v in data.items()}
        return {k: p[0] for k, p in parts.items()}, [x for p in parts.values() for x in p[1]]
    if isinstance(data, Sequence) and not isinstance(data, str):
        items = [_taken_apart(v) for v in data]
        return [i[0] for i in items], [x for i in items for x in i[1]]
    return data, []


def _natural(name: str) -> list[tuple[int, str]]:
    """A sorting key by which rational-10 comes after rational-9."""
    out: list[tuple[int, str]] = []
    for word in name.replace("_", "-").split("-"):
        out.append((int(word), "") if word.isdigit() else (-1, word))
    return out
