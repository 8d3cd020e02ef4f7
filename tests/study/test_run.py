"""A study from its file to its results: what is written, resumed, kept and said."""

import csv
import dataclasses
import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.config import read_config
from ecfit.study import runner
from ecfit.study.plan import make_plan
from ecfit.workers.home import Home, home
from ecfit.workers.job import Job

EXAMPLES = Path(__file__).parent.parent.parent / "examples"

CONFIG = """
name = "small"
[[tables]]
name = "e"
model = "conductor"
axes = { r = 12, mu = 12 }
tolerance = 1e-6
[[fits]]
tables = ["e"]
form = "polynomial"
degree = [1, 2]
[[fits]]
tables = ["e"]
form = "rational"
degree = 1
[[compare]]
tables = ["e"]
published = ["sforza-pellacini-2022-conductor"]
[report]
figures = ["svg"]
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, ecfit.Study]:
    """(config, results folder, study) of the small study, run once."""
    folder = tmp_path_factory.mktemp("study")
    config = folder / "small.toml"
    config.write_text(CONFIG)
    return config, folder / "results", ecfit.run(config, folder / "results")


def files(folder: Path) -> dict[str, bytes]:
    """All files below a folder but the timings."""
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and p.name != "timings.csv"
    }


def numbers(folder: Path) -> dict[str, bytes]:
    """Those that a run without a report writes."""
    return {
        name: content
        for name, content in files(folder).items()
        if "figures/" not in name and not name.endswith(("report.html", "report.md", "proofs.json"))
    }


def test_a_study_writes_everything(finished):
    _, results, study = finished
    written = set(files(results / "small"))
    assert {"summary.csv", "config.toml", "provenance.json", "report.html", "report.md"} <= written
    assert {"fits/e-polynomial-1.json", "fits/e-polynomial-2.json", "fits/e-rational-1.json"} <= written
    assert "figures/e-degree-vs-error.svg" in written
    assert (results / "small" / "timings.csv").exists()
    assert len(list((results / "tables").glob("*.npz"))) == 1
    assert study.warnings() == []


def test_the_summary_has_a_row_a_fit_that_agrees_with_the_fit(finished):
    _, results, study = finished
    rows = list(csv.DictReader((results / "small" / "summary.csv").read_text().splitlines()))
    assert [(r["form"], r["degree"], r["coefficients"], r["status"]) for r in rows] == [
        ("polynomial", "1", "3", "converged"),
        ("polynomial", "2", "6", "converged"),
        ("rational", "1", "5", "converged"),
        ("sforza-pellacini-2022-conductor", "3", "19", "published"),
    ]
    for row, fit in zip(rows, study.fits["e"], strict=False):
        assert float(row["mae"]) == pytest.approx(fit.mae, rel=1e-6)
        assert float(row["min_denominator"]) == pytest.approx(fit.smallest.value, rel=1e-6)


def test_running_again_computes_nothing_and_changes_no_byte(finished):
    config, results, _ = finished
    before = files(results)
    again = ecfit.run(config, results)
    assert again.seconds == {}
    assert files(results) == before


def test_another_process_writes_the_same_bytes(finished, tmp_path: Path):
    """All files: tables, coefficients, figures, pages. Times are in `timings.csv` only."""
    config, results, _ = finished
    program = "import sys, ecfit; ecfit.run(sys.argv[1], sys.argv[2])"
    subprocess.run(
        [sys.executable, "-c", program, str(config), str(tmp_path / "elsewhere" / "results")],
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "1", "TZ": "Asia/Tokyo", "HOME": str(tmp_path)},
    )
    first, again = files(results), files(tmp_path / "elsewhere" / "results")
    assert {Path(name).suffix for name in first} == {
        ".csv", ".html", ".json", ".md", ".npz", ".svg", ".toml"
    }  # fmt: skip
    assert [name for name in first if again.get(name) != first[name]] == []
    assert again.keys() == first.keys()


@pytest.mark.usefixtures("no_report")
def test_only_what_changed_is_computed_again(finished, tmp_path: Path):
    config, results, _ = finished
    copy = tmp_path / "results"
    shutil.copytree(results, copy)
    (copy / "small" / "fits" / "e-polynomial-2.json").unlink()
    (copy / "small" / "fits" / "e-rational-1.json").write_text("{ half a file")
    assert set(ecfit.run(config, copy).seconds) == {"fit e-polynomial-2", "fit e-rational-1"}
    assert numbers(copy / "small") == numbers(results / "small")


@pytest.mark.usefixtures("no_report")
def test_a_damaged_table_is_computed_again(finished, tmp_path: Path):
    config, results, _ = finished
    copy = tmp_path / "results"
    shutil.copytree(results, copy)
    (table,) = (copy / "tables").glob("*.npz")
    whole = table.read_bytes()
    table.write_bytes(whole[:1000])
    assert "table e" in ecfit.run(config, copy).seconds
    assert table.read_bytes() == whole


@pytest.mark.usefixtures("no_report")
def test_a_fresh_run_of_the_resolved_config_gives_the_same_bytes(finished, tmp_path: Path):
    """So do two of one config: the resolved config of both is the same. The report is the same where its
    numbers are, as running again shows."""
    _, results, _ = finished
    ecfit.run(results / "small" / "config.toml", tmp_path / "results")
    again = numbers(tmp_path / "results" / "small")
    assert again == numbers(results / "small")


class Stop(runner.Progress):
    """An interrupt after the second fit."""

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        done = 0

        def advance(steps: int) -> None:
            nonlocal done
            done += steps
            if title == "fits" and done == 2:
                raise KeyboardInterrupt

        yield advance


@pytest.mark.usefixtures("no_report")
def test_a_stopped_run_keeps_what_was_finished(finished, tmp_path: Path):
    config, results, _ = finished
    shutil.copytree(results / "tables", tmp_path / "results" / "tables")
    with pytest.raises(KeyboardInterrupt):
        ecfit.run(config, tmp_path / "results", progress=Stop())
    assert set(ecfit.run(config, tmp_path / "results").seconds) == {"fit e-rational-1"}


@dataclasses.dataclass
class Dying:
    """An engine whose workers die at the end of their tasks, which begin again; `deaf`: unheard till then."""

    deaf: bool

    def run(self, job: Job, done: Callable, heard: Callable) -> None:
        for index in job.order:
            for way_home in (Home((lambda message: None) if self.deaf else heard), Home(heard)):
                before = home.set(way_home)
                result = job.function(job.tasks[index])
                home.reset(before)
            done(index, result)


@pytest.mark.usefixtures("no_report")
@pytest.mark.parametrize("deaf", [False, True])
def test_every_fit_is_told_once_however_often_its_worker_died(finished, tmp_path: Path, deaf: bool):
    config, results, _ = finished
    shutil.copytree(results / "tables", tmp_path / "results" / "tables")
    steps: list[int] = []

    class Steps(runner.Progress):
        @contextmanager
        def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
            yield steps.append

    plan = make_plan(read_config(config), config.parent)
    study = runner._run(plan, config.parent, tmp_path / "results", Dying(deaf), Steps())
    assert steps == [0, 1, 1, 1]
    assert len(study.seconds) == (0 if deaf else 3)  # how long it took was lost


TWO_TABLES = """
name = "two"
[[tables]]
name = "e"
file = "e.csv"
axes = { r = 12, mu = 12 }
[[tables]]
name = "f"
file = "f.csv"
axes = { r = 12, mu = 12 }
[[fits]]
tables = ["f"]
form = "polynomial"
degree = 2
[[fits]]
tables = ["e"]
form = "rational"
degree = 1
"""


@pytest.mark.usefixtures("no_report")
def test_no_byte_depends_on_the_number_of_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Nor on the threads of this process: fits are computed in workers with one thread each."""
    monkeypatch.setenv("PJRT_NPROC", "2")
    r, mu = np.meshgrid(*[np.linspace(0.0, 1.0, 12)] * 2, indexing="ij")
    np.savetxt(tmp_path / "e.csv", 1.0 - 0.5 * r**2 + 0.1 * mu, delimiter=",")
    np.savetxt(tmp_path / "f.csv", np.exp(-r * mu), delimiter=",")
    config = tmp_path / "two.toml"
    config.write_text(TWO_TABLES)
    one = ecfit.run(config, tmp_path / "one", workers=1)
    shutil.copytree(tmp_path / "one" / "tables", tmp_path / "two" / "tables")
    two = ecfit.run(config, tmp_path / "two", workers=2)
    assert files(tmp_path / "one") == files(tmp_path / "two")
    fits = {"fit e-rational-1", "fit f-polynomial-2"}
    assert set(two.seconds) == fits
    assert set(one.seconds) == fits | {"table e", "table f"}


def test_a_fit_that_fails_in_a_worker_is_told(finished, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    config, results, study = finished
    monkeypatch.setenv("PJRT_NPROC", "2")  # so that there is a worker
    shutil.copytree(results / "tables", tmp_path / "results" / "tables")
    (path,) = (tmp_path / "results" / "tables").glob("*.npz")
    table = study.tables["e"]
    values = table.values.copy()
    values[0, 0] = np.nan
    dataclasses.replace(table, values=values).save(path)
    with pytest.raises(ecfit.EcfitError, match=r"^fit 'e-polynomial-1': the table has 1 of 144 entries"):
        ecfit.run(config, tmp_path / "results")


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_a_bad_number_of_workers_is_told_before_anything_is_computed(tmp_path: Path, workers):
    with pytest.raises(ecfit.EcfitError, match="workers must be a whole number, 1 or more"):
        ecfit.run(tmp_path / "nowhere.toml", tmp_path / "results", workers=workers)


def test_a_study_is_loaded_from_disk_alone(finished, tmp_path: Path):
    config, results, study = finished
    found = ecfit.study.load(config, results)
    assert [f.mae for f in found.fits["e"]] == [f.mae for f in study.fits["e"]]
    with pytest.raises(ecfit.EcfitError, match="no such table"):
        ecfit.study.load(config, tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ('model = "conductor"', 'model = "conducter"'),
            "unknown model 'conducter'.*did you mean 'conductor'",
        ),
        (("r = 12", "alpha = { count = 12, high = 2.0 }"), "outside the model's domain"),
        (("r = 12", "F0 = 12"), "no effect with"),
        (("degree = [1, 2]", "degree = 12"), "needs more than 12 nodes on axis 'r'"),
        (("sforza-pellacini-2022-conductor", "sforza"), "unknown published fit 'sforza'"),
        (('name = "small"', 'name = "small"\nplugins = ["nowhere.py"]'), "plugin 'nowhere.py': no such file"),
    ],
)
def test_what_cannot_be_done_is_told_before_anything_is_computed(
    tmp_path: Path, change: tuple[str, str], message: str
):
    assert change[0] in CONFIG
    config = tmp_path / "bad.toml"
    config.write_text(CONFIG.replace(*change, 1))
    with pytest.raises(ecfit.EcfitError, match=message):
        ecfit.run(config, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_a_results_folder_that_is_a_file_is_told(tmp_path: Path):
    (tmp_path / "results").write_text("")
    config = tmp_path / "small.toml"
    config.write_text(CONFIG)
    with pytest.raises(ecfit.EcfitError, match="cannot create the folder"):
        ecfit.run(config, tmp_path / "results")


def test_a_failing_plugin_is_told(tmp_path: Path):
    (tmp_path / "broken.py").write_text("1 / 0\n")
    config = tmp_path / "bad.toml"
    config.write_text(CONFIG.replace('name = "small"', 'name = "small"\nplugins = ["broken.py"]', 1))
    with pytest.raises(ecfit.EcfitError, match=r"broken.py' failed to import: ZeroDivisionError"):
        ecfit.run(config, tmp_path / "results")


@pytest.mark.usefixtures("no_report")
def test_a_users_model_goes_through_a_study(tmp_path: Path):
    text = (EXAMPLES / "ward.toml").read_text()
    shutil.copy(EXAMPLES / "ward.py", tmp_path / "ward.py")
    nodes = "alpha = [0.3, 0.6, 0.8, 1.0], mu = [0.3, 0.5, 0.8, 1.0]"
    small = text.replace("alpha = 24, mu = { count = 24, low = 0.05 }", nodes)
    assert small != text
    small = small.replace("tolerance = 1e-6", "tolerance = 1e-3")
    small = small[: small.rindex("[[fits]]")].replace("[1, 2, 3, 4]", "[1, 2]")
    (tmp_path / "ward.toml").write_text(small)
    study = ecfit.run(tmp_path / "ward.toml", tmp_path / "results")
    assert study.tables["ward"].contract.model == "ward"
    assert [f.status for f in study.fits["ward"]] == ["converged"] * 2
    assert "ward" in (study.folder / "summary.csv").read_text()


def test_provenance_names_versions_hashes_and_the_machine(finished):
    _, results, study = finished
    data = json.loads((results / "small" / "provenance.json").read_text())
    table = data["tables"]["e"]
    assert table["key"] == study.tables["e"].provenance["key"]
    assert table["values"] == study.tables["e"].digest
    for versions in (data["versions"], table["versions"]):
        assert not {"ecfit", "equinox", "jax", "jaxlib", "lineax", "numpy", "python"} - set(versions)
    assert data["config"] == hashlib.sha256((results / "small" / "config.toml").read_bytes()).hexdigest()
    assert set(data["machine"]) == {"system", "instructions", "xla_flags"}
    assert data["machine"]["xla_flags"] == os.environ.get("XLA_FLAGS", "")


@pytest.mark.usefixtures("no_report")
def test_what_computes_nothing_does_not_say_that_it_made_the_numbers(
    finished, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    config, results, _ = finished
    copy = tmp_path / "results"
    shutil.copytree(results, copy)
    path = copy / "small" / "provenance.json"
    before = path.read_bytes()
    monkeypatch.setattr("ecfit.study.provenance.instruction_set", lambda: "another")
    runner.write_results(runner.load(config, copy))
    ecfit.run(config, copy)
    assert path.read_bytes() == before
    (copy / "small" / "fits" / "e-polynomial-2.json").unlink()
    ecfit.run(config, copy)
    assert json.loads(path.read_text())["machine"]["instructions"] == "another"
    path.unlink()
    runner.write_results(runner.load(config, copy))  # a report needs none, and makes none up
    assert not path.exists()
    path.write_text("[]")
    ecfit.run(config, copy)
    assert json.loads(path.read_text())["config"] == json.loads(before)["config"]
