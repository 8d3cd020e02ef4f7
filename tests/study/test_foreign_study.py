"""Somebody's own table in a study: fitted, judged, reported and run again like ours, without a model."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.config import read_config
from ecfit.study.plan import make_plan

CONFIG = """
name = "theirs"
[[tables]]
name = "mine"
file = "data/mine.csv"
stored = "1-E"
order = ["mu", "r"]
axes = { r = 6, mu = { count = 8, spacing = "texel-centre" } }
options = { masking = "height-correlated, they say" }
[[tables]]
name = "curve"
file = "data/curve.npy"
quantity = "average-albedo"
axes = { r = 9 }
[[fits]]
tables = ["mine", "curve"]
form = "polynomial"
degree = [1, 2]
[[compare]]
tables = ["mine"]
published = ["sforza-pellacini-2022-conductor"]
[report]
figures = ["svg"]
"""
R, MU = np.linspace(0, 1, 6), (np.arange(8) + 0.5) / 8
ALBEDO = 1.0 - 0.6 * R[:, None] ** 2 + 0.05 * (R[:, None] * MU)  # [r, mu], of degree 2


def written(folder: Path, config: str = CONFIG) -> Path:
    (folder / "data").mkdir(parents=True)
    np.savetxt(folder / "data" / "mine.csv", 1.0 - ALBEDO.T, delimiter=",", fmt="%.9f")
    np.save(folder / "data" / "curve.npy", 1.0 - 0.5 * np.linspace(0, 1, 9) ** 2)
    (folder / "theirs.toml").write_text(config)
    return folder / "theirs.toml"


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, ecfit.Study]:
    folder = tmp_path_factory.mktemp("foreign")
    config = written(folder / "there")
    return config, folder / "results", ecfit.run(config, folder / "results", workers=1)


def files(folder: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and p.name != "timings.csv"
    }


def test_a_foreign_table_is_fitted_like_ours(finished):
    _, results, study = finished
    np.testing.assert_allclose(study.tables["mine"].values, ALBEDO, atol=1e-9)
    assert study.fits["mine"][1].max_error < 1e-8
    assert all(f.ok for fits in study.fits.values() for f in fits)
    rows = list(csv.DictReader((results / "theirs" / "summary.csv").read_text().splitlines()))
    assert [r["table"] for r in rows] == ["mine"] * 2 + ["curve"] * 2 + ["mine"]
    assert rows[-1]["status"] == "published"


def test_the_contract_says_no_more_than_the_config(finished):
    contract = finished[2].tables["mine"].contract
    assert contract.model == "unknown"
    assert contract.options == {"masking": "height-correlated, they say"}
    assert contract.stored == "E"


def test_a_foreign_table_is_reported_without_nonsense(finished):
    _, results, study = finished
    for page in ("report.html", "report.md"):
        report = (results / "theirs" / page).read_text()
        assert "given, not integrated here: no error estimate (source: mine.csv)" in report
        assert "source mine.csv" in report or page.endswith("md")
        assert "log10 of the error estimate" not in report
        assert "The table, as given." in report
        assert "WARNING" not in report
        assert "tolerance" not in report
        assert " nan" not in report
    assert study.warnings() == []
    assert (results / "theirs" / "figures" / "mine-table.svg").exists()
    assert (results / "theirs" / "figures" / "curve-table.svg").exists()


@pytest.mark.usefixtures("no_report")
def test_running_again_computes_nothing_until_the_file_changes(finished, tmp_path: Path):
    config, results, _ = finished
    before = files(results)
    assert ecfit.run(config, results, workers=1).seconds == {}
    assert files(results) == before
    assert ecfit.study.load(config, results).fits["mine"][0].mae == finished[2].fits["mine"][0].mae

    other = written(tmp_path / "there")
    shutil.copytree(results, tmp_path / "results")
    np.save(tmp_path / "there" / "data" / "curve.npy", 1.0 - 0.4 * np.linspace(0, 1, 9) ** 3)
    again = ecfit.run(other, tmp_path / "results", workers=1)
    assert set(again.seconds) == {"table curve", "fit curve-polynomial-1", "fit curve-polynomial-2"}


@pytest.mark.usefixtures("no_report")
def test_the_resolved_config_runs_and_gives_the_same(finished, tmp_path: Path):
    _, results, _ = finished
    resolved = results / "theirs" / "config.toml"
    assert "tolerance" not in resolved.read_text()
    ecfit.run(resolved, tmp_path / "elsewhere" / "results", workers=1)
    before, after = files(results / "theirs"), files(tmp_path / "elsewhere" / "results" / "theirs")
    # The path to the file is another from there.
    assert before.pop("config.toml") != after.pop("config.toml")
    # So is therefore the hash of the config.
    before.pop("provenance.json"), after.pop("provenance.json")
    # That the report of one study is always the same is tested in test_run.
    assert after == {name: before[name] for name in after}
    assert "summary.csv" in after


@pytest.mark.usefixtures("no_report")
def test_a_table_that_looks_otherwise_is_warned_of(tmp_path: Path):
    head, _, _ = CONFIG.replace('stored = "1-E"\n', "").partition("[[fits]]")
    config = written(tmp_path, head)
    (warning,) = ecfit.run(config, tmp_path / "results", workers=1).warnings()
    assert warning.startswith("table mine: seen from above")
    assert "stored = '1-E'" in warning


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("data/mine.csv", "data/none.csv"), "table 'mine': no such file: '.*none.csv'"),
        (("data/mine.csv", "data"), "table 'mine': unknown kind of table file"),
        (('order = ["mu", "r"]\n', ""), r"8 x 6 numbers.*order = \['mu', 'r'\] would fit"),
        (('["mu", "r"]', '["mu", "alpha"]'), "order must name each axis once"),
        (("r = 6", "ior = 6"), "table 'mine': axis 'ior' has no range"),
        (("r = 9", "r = 9, mu = 1"), "greater than or equal to 2"),
        (("r = 9", "r = 8"), "holds 9 numbers, the axes need 8"),
        (('stored = "1-E"', 'model = "conducter"'), "unknown model 'conducter'"),
        (('stored = "1-E"', 'model = "conductor"'), "masking.*expected one of.*height-correlated"),
        (("degree = [1, 2]", "degree = 9"), "the table only 48 entries|needs more than 9 nodes"),
    ],
)
def test_what_cannot_be_done_is_told_before_anything_is_computed(tmp_path: Path, change, words):
    assert change[0] in CONFIG
    config = written(tmp_path, CONFIG.replace(*change, 1))
    with pytest.raises(ecfit.EcfitError, match=words):
        ecfit.run(config, tmp_path / "results", workers=1)
    assert not (tmp_path / "results").exists()


def test_a_claimed_model_is_held_to_its_options(tmp_path: Path):
    config = written(
        tmp_path,
        CONFIG.replace(
            'options = { masking = "height-correlated, they say" }',
            'model = "conductor"\noptions = { masking = "height-correlated", fresnel = "schlick", F0 = 0.9 }',
        ),
    )
    contract = make_plan(read_config(config), tmp_path).requests["mine"].contract
    assert contract.model == "conductor"
    assert contract.options == {"masking": "height-correlated", "fresnel": "schlick"}
    assert contract.parameters == {"F0": 0.9}
