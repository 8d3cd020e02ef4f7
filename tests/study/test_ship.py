"""Shipping: named fits are certified and written; what is there never changes."""

from dataclasses import replace
from pathlib import Path

import pytest

import ecfit
from ecfit.files import read_json, write_json
from ecfit.study import load, make_plan, run
from ecfit.study.ship import ship

CONFIG = """
name = "tiny"
[[tables]]
name = "conductor"
model = "conductor"
[tables.axes]
r = { count = 12, low = 0.03, spacing = "gauss" }
mu = { count = 12, low = 0.02, spacing = "gauss" }
[[fits]]
tables = ["conductor"]
form = "structured"
name = "tiny-10"
head = "corner"
features = ["alpha", "mu"]
digits = 6
[fits.terms]
numerators = [[[1, 0], [0, 1], [3, 0], [2, 1], [3.5, 0], [0.5, 3]]]
denominator = [[3, 0], [0, 3], [1.5, 1.5], [4.5, 1.5], [0.5, 3]]
[[fits]]
tables = ["conductor"]
form = "polynomial"
name = "tiny-line"
degree = 1
[[fits]]
tables = ["conductor"]
form = "polynomial"
degree = 2
"""


@pytest.fixture(scope="module")
def study(unreported, tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("ship")
    (folder / "tiny.toml").write_text(CONFIG)
    with unreported():
        run(folder / "tiny.toml", folder / "results", workers=1)
    found = load(folder / "tiny.toml", folder / "results")
    return make_plan(found.config, folder), found.fits


def test_named_fits_are_certified_or_refused_and_files_never_change(study, tmp_path: Path):
    plan, fits = study
    first = {s.name: s for s in ship(plan, fits, tmp_path, samples=50)}
    assert list(first) == ["tiny-10", "tiny-line"]  # the unnamed polynomial is no candidate
    assert first["tiny-10"].outcome == "shipped"
    assert first["tiny-line"].outcome.startswith("refused: ")  # a line exceeds 1 somewhere
    assert [p.stem for p in tmp_path.iterdir()] == ["tiny-10"]
    again = {s.name: s for s in ship(plan, fits, tmp_path, samples=50)}
    assert again["tiny-10"].outcome == "unchanged"

    path = tmp_path / "tiny-10.json"
    data = read_json(path)
    data["coefficients"][0] += 0.01
    write_json(path, data)
    before = path.read_bytes()
    changed = {s.name: s for s in ship(plan, fits, tmp_path, samples=50)}
    assert "choose a new name" in changed["tiny-10"].outcome
    assert path.read_bytes() == before


def test_a_shipped_file_is_an_approximation_with_its_certificate(study, tmp_path: Path):
    plan, fits = study
    ship(plan, fits, tmp_path, samples=50)
    found = ecfit.Approximation.from_dict(read_json(tmp_path / "tiny-10.json"))
    assert found(mu=0.0, alpha=0.0) == 1.0
    data = read_json(tmp_path / "tiny-10.json")
    assert data["certificate"]["name"] == "tiny-10"
    assert data["provenance"]["study"] == "tiny"


def test_a_study_without_names_has_nothing_to_ship(study, tmp_path: Path):
    plan, fits = study
    nameless = tuple(f.__class__(f.table, f.form, f.label, f.key, f.settings) for f in plan.fits)
    with pytest.raises(ecfit.EcfitError, match="names no fit"):
        ship(replace(plan, fits=nameless), fits, tmp_path)
