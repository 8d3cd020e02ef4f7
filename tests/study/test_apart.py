"""How far two runs are apart: nothing in two processes of one kind, next to nothing on other processors."""

import dataclasses
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit._processor import instruction_set
from ecfit.errors import EcfitError
from ecfit.study.apart import (
    SAME_ENTRY,
    SAME_FUNCTION,
    Apart,
    coefficients_apart,
    entries_apart,
    fits_apart,
    tables_apart,
)
from ecfit.study.apart import functions_apart as apart
from ecfit.workers import ONE_THREAD

SMALL = """
name = "small"
[[tables]]
name = "e"
file = "e.csv"
axes = { r = 9, mu = 9 }
[[fits]]
tables = ["e"]
form = "polynomial"
degree = 3
[[fits]]
tables = ["e"]
form = "rational"
degree = 2
"""

# What else a study may hold: an integrated table, terms that are given and that are searched for, a composed
# form, a module, what is judged beside them, and both kinds of figures.
REST = """
[[fits]]
tables = ["e"]
name = "module"
form = "module"
module = "written"
settings = { variables = ["r", "mu"], formula = "1 - a*r**4/(1 + b*mu)", constants = { a = 0.5, b = 0.1 } }
[[tables]]
name = "c"
model = "conductor"
axes = { r = { count = 9, low = 0.1 }, mu = { count = 9, low = 0.1, spacing = "gauss" } }
[[fits]]
tables = ["c"]
name = "given"
form = "structured"
head = "corner"
features = ["alpha", "mu"]
terms = { numerators = [[[1, 0], [0, 1]]], denominator = [[3, 0], [0, 3]] }
norm = "l4"
digits = 6
[[fits]]
tables = ["c"]
form = "selected"
head = "corner"
features = ["alpha", "mu"]
budget = [4, 6]
rounds = 2
seeds = 2
[fits.within]
numerators = [{ highest = { alpha = 2, mu = 2 }, lowest_order = 1, highest_order = 3 }]
denominator = { highest = { alpha = 3, mu = 3 }, lowest_order = 3, highest_order = 4 }
[[fits]]
tables = ["c"]
name = "whole"
form = "composed"
text = "min(E, 1)"
parts = { E = "given" }
[[compare]]
tables = ["c"]
published = ["sforza-pellacini-2022-conductor"]
lookups = [{ counts = { r = 5, mu = 5 } }]
[report]
figures = ["svg", "png"]
"""


def written(folder: Path, text: str) -> Path:
    """A study of a table in a file whose columns are nearly dependent in the forms that are fitted to it."""
    r, mu = np.meshgrid(*[np.linspace(0.0, 1.0, 9)] * 2, indexing="ij")
    np.savetxt(
        folder / "e.csv", 1.0 - 0.6 * r**4 * np.exp(-0.5 * mu) - 0.05 * np.sin(3 * mu * r), delimiter=","
    )
    (folder / "small.toml").write_text(text)
    return folder / "small.toml"


def process(config: Path, results: Path, report: bool = False, workers: int = 1, **environment: str) -> None:
    """A run in a process of its own, with one thread unless the environment says otherwise."""
    program = "import sys, ecfit, ecfit.report\n" + (
        "" if report else "ecfit.report.write_report = lambda s: 0\n"
    )
    program += "ecfit.run(sys.argv[1], sys.argv[2], workers=int(sys.argv[3]))"
    subprocess.run(
        [sys.executable, "-c", program, str(config), str(results), str(workers)],
        check=True,
        env={**os.environ, **ONE_THREAD, **environment},
    )


def processor(isa: str, blas: str) -> dict[str, str]:
    """XLA and OpenBLAS held to a lesser processor, which add in another order and fuse no products."""
    flags = os.environ.get("XLA_FLAGS", "")
    return {"XLA_FLAGS": f"{flags} --xla_cpu_max_isa={isa}".strip(), "OPENBLAS_CORETYPE": blas}


def kept(config: Path, old: Path, new: Path) -> list[Apart]:
    """Assert what `apart` promises."""
    found = fits_apart(config, old, new)
    assert max(tables_apart(config, old, new).values()) <= SAME_ENTRY
    assert [f for f in found if not f.same] == []
    return found


@pytest.mark.usefixtures("no_report")
def test_a_lesser_processor_gives_the_same_functions(tmp_path: Path):
    if instruction_set() not in ("AVX-512", "AVX2", "AVX"):
        pytest.skip(f"no processor is lesser than this one ({instruction_set()})")
    config = written(tmp_path, SMALL)
    ecfit.run(config, tmp_path / "here", workers=1)
    process(config, tmp_path / "there", **processor("SSE4_2", "Nehalem"))
    polynomial, rational = kept(config, tmp_path / "here", tmp_path / "there")
    assert polynomial.label == "e-polynomial-3"
    stored = [[p.read_bytes() for p in fit_files(tmp_path / place)] for place in ("here", "there")]
    assert stored[0] != stored[1], "nothing moved: was it another processor at all?"
    # Far within the promise here: it is made for the worst of forms.
    assert max(polynomial.coefficients, rational.coefficients) < 1e-6
    assert max(polynomial.share, rational.share) < 0.1 * SAME_FUNCTION


def fit_files(results: Path) -> list[Path]:
    return sorted((results / "small" / "fits").glob("*.json"))


def files(folder: Path) -> dict[str, bytes]:
    """All that was written, but how long it took."""
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and p.name != "timings.csv"
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """(config, results) of a study of every kind of form, with its report."""
    folder = tmp_path_factory.mktemp("whole")
    config = written(folder, SMALL + REST)
    process(config, folder / "results", report=True, PYTHONHASHSEED="1")
    return config, folder / "results"


@pytest.mark.slow
def test_two_processes_write_the_same_bytes_whatever_their_threads_workers_and_hashes(whole):
    """Every kind of artefact: tables, searches, fits of every kind, summaries, proofs, figures, pages."""
    config, results = whole
    again = config.parent / "again"  # the resolved config names files as they are seen from its folder
    two = dict.fromkeys(ONE_THREAD, "2")
    process(config, again, report=True, workers=2, PYTHONHASHSEED="2", TZ="Asia/Tokyo", **two)
    one, other = files(results), files(again)
    assert [name for name in one if other.get(name) != one[name]] == []
    assert one.keys() == other.keys()
    kinds = {Path(name).parts[1] for name in one if name.startswith("small")}
    assert kinds >= {
        "fits",
        "figures",
        "searches",
        "report.html",
        "report.md",
        "summary.csv",
        "provenance.json",
    }
    assert {Path(name).suffix for name in one} >= {".png", ".svg", ".npz", ".csv", ".json", ".html"}


@pytest.mark.slow
@pytest.mark.parametrize(("isa", "blas"), [("SSE4_2", "Nehalem"), ("AVX2", "Haswell")])
def test_every_kind_of_form_is_the_same_on_lesser_processors(whole, tmp_path: Path, isa: str, blas: str):
    config, results = whole
    process(config, tmp_path, **processor(isa, blas))
    kept(config, results, tmp_path)


@pytest.mark.usefixtures("no_report")
def test_what_moved_is_seen(tmp_path: Path):
    config = written(tmp_path, SMALL)
    ecfit.run(config, tmp_path / "old", workers=1)
    shutil.copytree(tmp_path / "old", tmp_path / "new")
    assert [f.function for f in kept(config, tmp_path / "old", tmp_path / "new")] == [0.0, 0.0]
    path = tmp_path / "new" / "small" / "fits" / "e-rational-2.json"
    data = json.loads(path.read_text())
    data["coefficients"][0] *= 1.0 + 1e-4
    path.write_text(json.dumps(data))
    polynomial, rational = fits_apart(config, tmp_path / "old", tmp_path / "new")
    assert polynomial.same
    assert not rational.same
    assert rational.coefficients == pytest.approx(1e-4, rel=1e-6)
    assert rational.function > 1e-5
    (table,) = (tmp_path / "new" / "tables").glob("*.npz")
    stored = ecfit.Table.load(table)
    dataclasses.replace(stored, values=stored.values + 1e-15).save(table)
    assert tables_apart(config, tmp_path / "old", tmp_path / "new") == {"e": np.inf}
    # Other terms of the same number are no neighbours, whatever their coefficients.
    data["numerator_exponents"].reverse()
    path.write_text(json.dumps(data))
    assert fits_apart(config, tmp_path / "old", tmp_path / "new")[1].coefficients == np.inf
    path.write_text(json.dumps({**data, "key": "other"}))
    with pytest.raises(EcfitError, match="another study file or version"):
        fits_apart(config, tmp_path / "old", tmp_path / "new")
    path.unlink()
    with pytest.raises(EcfitError, match="no such file"):
        fits_apart(config, tmp_path / "old", tmp_path / "new")


def test_entries_without_a_value_are_equal_where_both_runs_have_none():
    a = np.array([np.nan, 1.0, np.nan])
    assert entries_apart(a, a).tolist() == [0.0, 0.0, 0.0]
    assert entries_apart(a, np.array([np.nan, 1.5, 0.0])).tolist() == [0.0, 0.5, np.inf]


def test_functions_are_compared_over_the_closed_domain(make_table, unit_axis):
    table = make_table(lambda r, mu: 1.0 - 0.5 * r + 0.1 * mu, unit_axis("r", 4), unit_axis("mu", 4))
    one = ecfit.fit(table, ecfit.Polynomial(1)).approximation
    values = np.array(one.coefficients)
    values[1] += 1e-3  # r, which is 1 at its end
    assert apart(one, one) == 0.0
    assert apart(one, one.with_quotient(values=values)) == pytest.approx(1e-3)
    pole = ecfit.fit(table, ecfit.Rational(1)).approximation
    assert apart(one, pole) < 1e-6
    pole = pole.with_quotient(values=np.array([1.0, 0.0, 0.0, -1.0, 0.0]))  # 1 / (1 - r)
    assert apart(one, pole) == apart(pole, one) == np.inf
    assert apart(pole, pole) == 0.0
    with pytest.raises(EcfitError, match="other variables or domains"):
        apart(one, dataclasses.replace(one, domain=((0.0, 0.5), (0.0, 1.0))))


def test_coefficients_are_compared_one_by_one():
    a = np.array([1.0, 0.0, -1e-6])
    assert coefficients_apart(a, a) == 0.0
    assert coefficients_apart(a, a * np.array([1.0, 1.0, 1.5])) == pytest.approx(0.5)
    assert coefficients_apart(a, np.array([1.0, 1e-9, -1e-6])) == np.inf
    assert coefficients_apart(a, a[:2]) == np.inf
