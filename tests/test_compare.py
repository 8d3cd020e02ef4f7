"""`ecfit compare`: what changed between two runs, and the exit code of a script that watches it."""

import csv
import json
import shutil
from pathlib import Path

import pytest

from ecfit.compare import compare
from ecfit.errors import EcfitError

ROOT = Path(__file__).parent.parent


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    """The committed results of the quick study, twice."""
    for name in ("a", "b"):
        shutil.copytree(ROOT / "results/quick", tmp_path / name, ignore=shutil.ignore_patterns("figures"))
    return tmp_path / "a", tmp_path / "b"


def edit_fit(folder: Path, name: str, **changes) -> None:
    """Scale numbers of a fit's errors, or set its status or first coefficient."""
    path = folder / f"fits/{name}.json"
    data = json.loads(path.read_text())
    for key, value in changes.items():
        if key == "status":
            data["fit"]["status"] = value
        elif key == "coefficient":
            data["coefficients"][0] += value
        else:
            data["fit"]["errors"][key] *= value
    path.write_text(json.dumps(data))


def told(runs: tuple[Path, Path], **options) -> list[tuple[str, str, str]]:
    return [(c.kind, c.part, c.name) for c in compare(*runs, **options).changes]


def test_a_run_is_like_itself(runs):
    found = compare(*runs)
    assert found.changes == ()
    assert not found.worse
    assert found.same == 1 + 8 + 4  # the table, the fits, one published and three shipped ones


def test_an_error_that_rises_is_worse_and_one_that_falls_better(runs):
    edit_fit(runs[1], "conductor-rational-3", rmse=1.5)
    edit_fit(runs[1], "conductor-rational-2", max_error=0.5)
    assert told(runs) == [
        ("WORSE", "fit", "conductor-rational-3"),
        ("better", "fit", "conductor-rational-2"),
    ]
    found = compare(*runs)
    assert found.worse
    assert "(+50 %)" in found.changes[0].text
    assert not compare(*runs, tolerance=0.6).changes
    back = compare(runs[1], runs[0])
    assert [(c.kind, c.name[-1]) for c in back.changes] == [("WORSE", "2"), ("better", "3")]


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ("converged", "pole", "WORSE"), ("converged", "not-converged", "WORSE"),
        ("not-converged", "pole", "WORSE"), ("pole", "not-converged", "better"),
        ("pole", "converged", "better"),
    ],
)  # fmt: skip
def test_statuses_have_an_order(runs, old: str, new: str, kind: str):
    edit_fit(runs[0], "conductor-rational-1", status=old)
    edit_fit(runs[1], "conductor-rational-1", status=new)
    assert told(runs) == [(kind, "fit", "conductor-rational-1")]


def test_coefficients_that_move_are_neither_better_nor_worse(runs):
    edit_fit(runs[1], "conductor-rational-1", coefficient=1e-4)
    found = compare(*runs)
    assert [(c.kind, c.text[:21]) for c in found.changes] == [("moved", "coefficients by 9.9e-")]
    assert not found.worse
    assert not compare(*runs, coefficients=1e-3).changes


def test_another_domain_is_another_form(runs):
    path = runs[1] / "fits/conductor-rational-1.json"
    data = json.loads(path.read_text())
    data["variables"] = ["alpha", "mu"]
    path.write_text(json.dumps(data))
    assert [c.text for c in compare(*runs).changes] == ["another form, domain or contract"]


def test_what_is_gone_is_worse_and_what_is_new_is_not(runs):
    (runs[1] / "fits/conductor-rational-4.json").unlink()
    assert told(runs) == [("GONE", "fit", "conductor-rational-4")]
    assert compare(*runs).worse
    assert told(runs[::-1]) == [("new", "fit", "conductor-rational-4")]
    assert not compare(*runs[::-1]).worse


@pytest.mark.parametrize("name", ["sforza-pellacini-2022-conductor", "conductor-16"])
def test_an_error_of_a_fixed_formula_that_moves_says_that_the_truth_did(runs, name):
    path = runs[1] / "summary.csv"
    rows = list(csv.DictReader(path.read_text().splitlines()))
    next(row for row in rows if row["form"] == name)["mae"] = "1.0"
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    assert told(runs) == [("moved", "published", f"conductor: {name}")]
    assert not compare(*runs).worse


def test_another_key_of_a_table_and_other_versions_are_told(runs):
    path = runs[1] / "provenance.json"
    data = json.loads(path.read_text())
    data["tables"]["conductor"]["key"] = "0123"
    data["versions"] |= {"jax": "99.0", "recorded-since": "1"}
    path.write_text(json.dumps(data))
    found = compare(*runs)
    assert [(c.kind, c.part, c.name) for c in found.changes] == [("moved", "table", "conductor")]
    assert len(found.versions) == 1
    assert found.versions[0].endswith("-> 99.0")


def test_an_unbounded_furnace_is_worse_than_any(runs):
    path = runs[1] / "fits/conductor-rational-1.json"
    data = json.loads(path.read_text())
    data["fit"]["errors"]["furnace_max"] = None
    path.write_text(json.dumps(data))
    (change,) = compare(*runs).changes
    assert (change.kind, change.text[-6:]) == ("WORSE", "-> inf")


def test_rounding_is_no_change(runs):
    """Of a fit that is exact: 1e-16 against 3e-16."""
    for folder, size in zip(runs, (1e-16, 3e-16), strict=True):
        edit_fit(folder, "conductor-rational-1", mae=0.0, rmse=0.0, max_error=0.0)
        path = folder / "fits/conductor-rational-1.json"
        path.write_text(path.read_text().replace('"rmse": 0.0', f'"rmse": {size}'))
    assert told(runs) == []


def test_lines_end_with_the_count_of_each_kind(runs):
    edit_fit(runs[1], "conductor-rational-3", rmse=1.5)
    lines = compare(*runs).describe()
    assert lines[0] == f"{runs[0]} -> {runs[1]}"
    assert lines[-1].startswith("1 worse, 0 gone, 0 better, 0 moved, 0 new, 12 the same (errors to 1 %, ")


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("provenance.json", "{}", "not what a run writes"),
        ("provenance.json", "[1", "not valid JSON"),
        ("fits/conductor-rational-1.json", "{}", "is not a fit"),
        ("fits/conductor-rational-1.json", "[]", "is not a fit"),
        ("summary.csv", "a,b\n1,2\n", "is not a summary"),
        ("summary.csv", "table,form,status,mae\nt,f,published,x\n", "is not a summary"),
    ],
)
def test_damaged_results_are_named(runs, file: str, text: str, message: str):
    (runs[1] / file).write_text(text)
    with pytest.raises(EcfitError, match=message):
        compare(*runs)


def test_other_folders_and_tolerances_are_refused(runs, tmp_path: Path):
    with pytest.raises(EcfitError, match="has no summary.csv"):
        compare(runs[0], tmp_path)
    for option in ("tolerance", "coefficients"):
        for value in (0.0, -1.0, float("nan"), float("inf")):
            with pytest.raises(EcfitError, match=option):
                compare(*runs, **{option: value})
