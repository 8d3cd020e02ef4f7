"""Verification: committed results hold, and whatever was changed in them is found."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ecfit
from ecfit.study.verify import Verification, verify

RESULTS = Path(__file__).parent.parent.parent / "results"
LABEL = "fits/conductor-rational-3.json"
# `entries` of the cheap checks: few nodes, drawn of 1024.
FEW = 24


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A copy of a committed study, to be tampered with."""
    return shutil.copytree(RESULTS / "conductor-clamped", tmp_path / "results" / "conductor-clamped")


def failed(found: Verification) -> list[str]:
    return [f"{f.what}: {f.text}" for f in found.findings if not f.holds]


@pytest.mark.parametrize(
    "name",
    [
        "conductor-clamped",
        pytest.param("quick", marks=pytest.mark.slow),
        pytest.param("gotanda", marks=pytest.mark.slow),
        pytest.param("paper-small", marks=pytest.mark.slow),
    ],
)
def test_committed_studies_hold(name: str):
    """What CI relies on: entries integrated again, errors of small tables measured again."""
    found = verify(RESULTS / name, refits=0)
    assert failed(found) == []
    assert found
    assert found.describe()[-1] == f"all {len(found.findings)} hold"


@pytest.mark.slow
def test_a_committed_rational_is_made_again():
    found = verify(RESULTS / "conductor-clamped", refits=1)
    assert failed(found) == []
    assert found
    text = "\n".join(found.describe())
    assert "1024 of 1024 entries integrated again" in text
    assert "measured again" in text
    assert "made again: RMSE" in text
    assert found.describe()[-1] == f"all {len(found.findings)} hold"


def change(path: Path, how: Callable[[Any], None]) -> None:
    data = json.loads(path.read_text())
    how(data)
    path.write_text(json.dumps(data))


def set_in(*place: Any, factor: float) -> Callable[[Any], None]:
    def how(data: Any) -> None:
        for key in place[:-1]:
            data = data[key]
        data[place[-1]] *= factor

    return how


@pytest.mark.parametrize(
    ("how", "message"),
    [
        (set_in("coefficients", 0, factor=1.0 + 1e-4), "at the place of the largest error, said to be"),
        (set_in("coefficients", 3, factor=1.0 + 1e-4), "its values reach"),
        (set_in("coefficients", 12, factor=1.0 + 1e-4), "the smallest denominator is"),
        (set_in("fit", "errors", "max_error", factor=0.999), "at the place of the largest error"),
        (set_in("fit", "errors", "max_error", factor=1.001), "at the place of the largest error"),
        (lambda data: data["fit"]["errors"]["place"].update(r=0.5), "at the place of the largest error"),
        (set_in("fit", "smallest_denominator", "value", factor=1.01), "the smallest denominator is"),
        (lambda data: data["fit"]["errors"].update(place={}), "does not say where its largest error is"),
        (lambda data: data.update(coefficients=[]), "coefficients"),
    ],
)
def test_a_changed_fit_is_found(study: Path, how: Callable[[Any], None], message: str):
    change(study / LABEL, how)
    found = verify(study, entries=FEW, refits=0)
    assert not found
    assert any(message in line for line in failed(found))


@pytest.mark.parametrize("name", ["mae", "rmse"])
def test_a_changed_mean_error_is_found_where_the_table_is_integrated_whole(study: Path, name: str):
    change(study / LABEL, set_in("fit", "errors", name, factor=1.0 + 1e-4))
    found = verify(study, entries=1024, refits=0)
    assert any(f"{name.upper()} " in line and "said to be" in line for line in failed(found))


@pytest.mark.parametrize(
    "damage", [lambda text: "a,b\n1,2\n", lambda text: text.replace(",mae,", ",MAE,", 1)]
)
def test_a_summary_without_its_columns_is_found(study: Path, damage):
    path = study / "summary.csv"
    path.write_text(damage(path.read_text()))
    (fault,) = failed(verify(study, entries=4, refits=0))
    assert fault.startswith("summary.csv: the column ")


def test_a_summary_that_says_another_number_is_found(study: Path):
    path = study / "summary.csv"
    path.write_text(path.read_text().replace("rational,3,19,4.", "rational,3,19,3.", 1))
    found = verify(study, entries=FEW, refits=0)
    assert failed(found) == ["summary.csv: no row says what the file says of conductor-rational-3"]


def test_a_missing_fit_is_found_and_the_rest_is_still_looked_at(study: Path):
    (study / LABEL).unlink()
    found = verify(study, entries=FEW, refits=0)
    assert len(failed(found)) == 1
    assert "no such file" in failed(found)[0]
    assert len(found.findings) > 1


def test_a_stored_table_is_compared_entry_by_entry(study: Path):
    table = ecfit.tabulate(
        "conductor",
        {
            "r": ecfit.Axis.spaced("r", 32, 0.035, 1.0, "clamped"),
            "mu": ecfit.Axis.spaced("mu", 32, 0.02, 1.0, "clamped"),
        },
    )
    path = study.parent / "tables" / f"{table.provenance['key']}.npz"
    table.save(path)
    assert verify(study, entries=FEW, refits=0)
    values = table.values.copy()
    values[:, ::2] += 1e-5
    ecfit.Table(
        values, table.errors, table.status, table.axes, table.contract, table.tolerance, table.provenance
    ).save(path)
    (line,) = failed(verify(study, entries=FEW, refits=0))
    assert "differ by more than both error estimates" in line
    path.write_bytes(b"PK")
    assert any("damaged" in line for line in failed(verify(study, entries=FEW, refits=0)))


SMALL = """
name = "given"
[[tables]]
name = "e"
file = "e.csv"
axes = { r = 4, mu = 4 }
[[fits]]
tables = ["e"]
form = "polynomial"
degree = 1
"""


def given(folder: Path) -> Path:
    """A study of somebody's table; its folder."""
    (folder / "study.toml").write_text(SMALL)
    np.savetxt(folder / "e.csv", np.linspace(0.5, 1.0, 16).reshape(4, 4) ** 2, delimiter=",")
    return ecfit.run(folder / "study.toml", folder / "results").folder


@pytest.mark.usefixtures("no_report")
def test_a_study_of_a_file_holds_until_the_file_or_the_config_changes(tmp_path: Path):
    folder = given(tmp_path)
    data = json.loads((folder / "provenance.json").read_text())
    assert (
        data["tables"]["e"]["values"]
        == ecfit.Table.load(next((tmp_path / "results" / "tables").glob("*.npz"))).digest
    )
    found = verify(folder)
    assert found
    assert any("made again: RMSE" in str(f) for f in found.findings)
    config = folder / "config.toml"
    whole = config.read_text()
    config.write_text(whole + "\n# another\n")
    assert failed(verify(folder)) == ["provenance.json: is of another config.toml: one of them was changed"]
    config.write_text(whole)
    theirs = tmp_path / "e.csv"
    theirs.write_text(theirs.read_text().replace("1.0", "0.9", 1))
    assert any("has changed" in line for line in failed(verify(folder)))


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"tables": {"e": {}}}', '{"tables": [1]}', "null"])
@pytest.mark.usefixtures("no_report")
def test_damaged_provenance_is_a_finding(tmp_path: Path, content: str):
    folder = given(tmp_path)
    (folder / "provenance.json").write_text(content)
    assert any(line.startswith("provenance.json: ") for line in failed(verify(folder)))


def test_what_is_no_study_is_told(tmp_path: Path):
    with pytest.raises(ecfit.EcfitError, match="no such file"):
        verify(tmp_path)
    with pytest.raises(ecfit.EcfitError, match="entries >= 1"):
        verify(tmp_path, entries=0)


def test_the_command_says_the_verdict_and_exits_with_1(study: Path, capsys: pytest.CaptureFixture[str]):
    from ecfit import cli

    def called() -> tuple[object, str]:
        with pytest.raises(SystemExit) as stopped:
            cli.main(["verify", str(study), "--entries", str(FEW), "--refits", "0"])
        return stopped.value.code, capsys.readouterr().out.splitlines()[-1]

    assert called() == (0, "all 4 hold")
    change(study / LABEL, set_in("coefficients", 0, factor=1.1))
    assert called() == (1, "1 of 4 claims FAIL")
