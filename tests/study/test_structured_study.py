"""Structured and selected fits in a study: computed once, kept, and computed again where asked otherwise."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.config import read_config
from ecfit.study.plan import make_plan

CONFIG = """
name = "small"
[[tables]]
name = "e"
file = "e.csv"
axes = { r = 9, mu = 9 }
[[fits]]
tables = ["e"]
form = "structured"
name = "given"
head = "corner"
features = ["alpha", "mu"]
terms = { numerators = [[[0.0, 0.0], [0.0, 1.0]]], denominator = [[0.0, 0.0], [0.0, 1.0]] }
norm = "least-squares"
[[fits]]
tables = ["e"]
form = "selected"
head = "corner"
features = ["alpha", "mu"]
within.numerators = [{ highest = { mu = 1.0 } }]
within.denominator = { highest = { mu = 2.0 } }
budget = 3
rounds = 1
[report]
figures = ["svg"]
"""
R = MU = np.linspace(0.0, 1.0, 9)
VALUES = 1.0 - R[:, None] ** 4 * (0.5 + 0.2 * MU) / (1.0 + 0.6 * MU)


def run(folder: Path, text: str = CONFIG) -> ecfit.Study:
    np.savetxt(folder / "e.csv", VALUES, delimiter=",", fmt="%.17g")
    (folder / "small.toml").write_text(text)
    return ecfit.run(folder / "small.toml", folder / "results", workers=1)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ecfit.Study]:
    folder = tmp_path_factory.mktemp("structured")
    return folder, run(folder)


def test_both_are_fitted_and_reported(finished):
    folder, study = finished
    given, chosen = study.fits["e"]
    assert given.approximation.name == "given"
    np.testing.assert_allclose(given.coefficients, [0.5, 0.2, 0.6], atol=1e-4)
    assert chosen.ok
    assert chosen.max_error < 1e-4
    rows = list(csv.DictReader((folder / "results/small/summary.csv").read_text().splitlines()))
    assert [r["coefficients"] for r in rows] == ["3", "3"]
    assert (folder / "results/small/fits/given.json").exists()
    assert (folder / "results/small/fits/e-corner-selected-3.json").exists()
    for page in ("report.md", "report.html"):
        assert "given" in (folder / "results/small" / page).read_text()


@pytest.mark.usefixtures("no_report")
def test_running_again_computes_nothing(finished):
    folder, study = finished
    again = run(folder)
    assert again.seconds == {}
    np.testing.assert_array_equal(again.fits["e"][0].coefficients, study.fits["e"][0].coefficients)
    loaded = ecfit.study.load(folder / "small.toml", folder / "results")
    assert [f.to_dict() for f in loaded.fits["e"]] == [f.to_dict() for f in study.fits["e"]]


def test_the_least_error_is_in_the_summary_and_the_report_where_it_was_asked_for(finished, tmp_path: Path):
    pytest.importorskip("scipy")
    shutil.copytree(finished[0], tmp_path / "copy")
    asked = 'charted = true\nlower_bound = true\nnorm = "l4"'
    study = run(tmp_path / "copy", CONFIG.replace('norm = "least-squares"', asked, 1))
    given, chosen = study.fits["e"]
    assert given.least_max_error is not None
    assert 0.0 <= given.least_max_error <= given.max_error
    assert chosen.least_max_error is None
    assert '"charted": true' in (study.folder / "fits/given.json").read_text()
    rows = list(csv.DictReader((study.folder / "summary.csv").read_text().splitlines()))
    assert list(rows[0])[-1] == "max_over_least"
    assert float(rows[0]["max_over_least"] or "inf") >= 1.0
    assert rows[1]["max_over_least"] == ""
    for page in ("report.md", "report.html"):
        assert "over least" in (study.folder / page).read_text()
        assert "over least" not in (finished[0] / "results/small" / page).read_text()
    lines = (study.folder / "report.md").read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("| approximation"))
    assert len({line.count("|") for line in lines[first : first + 4]}) == 1


@pytest.mark.usefixtures("no_report")
@pytest.mark.parametrize(
    ("old", "new", "which"),
    [
        ('norm = "least-squares"', 'norm = "l1"', {"fit given"}),
        ('norm = "least-squares"', "digits = 4", {"fit given"}),
        ("rounds = 1", "rounds = 0", {"fit e-corner-selected-3", "search e, corner-selected, seed 0"}),
    ],
)
def test_another_setting_computes_that_fit_only(finished, tmp_path: Path, old: str, new: str, which: set):
    shutil.copytree(finished[0], tmp_path / "copy")
    assert set(run(tmp_path / "copy", CONFIG.replace(old, new, 1)).seconds) == which


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('head = "corner"', 'head = "crner"', "unknown head 'crner'"),
        ('["alpha", "mu"]', '["alpha", "F0"]', "function of alpha, F0, the table of r, mu"),
        ("[0.0, 1.0]]]", "[0.0]]]", "numerator: exponents must be rows of 2 numbers"),
        ("{ mu = 2.0 }", "{ nu = 2.0 }", "highest names 'nu'"),
        ("budget = 3", "budget = 30", "the budget is 30, but there are only 4"),
        ('["alpha", "mu"]', '["alpha", "mu"]\ncharted = 1', "charted"),
        (
            '"least-squares"',
            '"minimax"\nridge = 0.1',
            "fit 'given': ridge has no effect in the norm",
        ),
    ],
)
def test_what_cannot_be_fitted_is_told_before_anything_is_computed(tmp_path: Path, old, new, message: str):
    assert old in CONFIG
    with pytest.raises(ecfit.EcfitError, match=message):
        run(tmp_path, CONFIG.replace(old, new, 1))
    assert not (tmp_path / "results").exists()


def test_two_forms_of_one_name_are_told(tmp_path: Path):
    """Neither is dropped in silence; what is there twice is one."""
    section = CONFIG[CONFIG.index("[[fits]]") : CONFIG.index("[[fits]]", CONFIG.index("[[fits]]") + 1)]
    unnamed = section.replace('name = "given"\n', "")
    other = unnamed.replace("[0.0, 1.0]]]", "[1.0, 0.0]]]")
    head, tail = CONFIG[: CONFIG.index("[[fits]]")], '[report]\nfigures = ["svg"]\n'
    with pytest.raises(
        ecfit.EcfitError, match="fit 'e-corner-3': two different fits have this name: give each"
    ):
        run(tmp_path, head + unnamed + other + tail)
    (tmp_path / "small.toml").write_text(head + unnamed + unnamed + tail)
    assert len(make_plan(read_config(tmp_path / "small.toml"), tmp_path).fits) == 1
