"""The searches of a study are files of their own: shared by budgets, kept, run again where they are gone."""

import csv
import json

import pytest

import ecfit
from ecfit.config import read_config
from ecfit.study.plan import make_plan
from ecfit.study.runner import load

CONFIG = """
name = "searched"
[[tables]]
name = "conductor"
model = "conductor"
axes = { r = { count = 6, low = 0.1, spacing = "gauss" }, mu = { count = 6, low = 0.1, spacing = "gauss" } }
[[fits]]
tables = ["conductor"]
form = "selected"
head = "corner"
features = ["alpha", "mu"]
budget = [3, 4]
rounds = 2
seeds = 2
[fits.within]
numerators = [{ highest = { alpha = 1, mu = 1 }, lowest_order = 1, highest_order = 2 }]
denominator = { highest = { alpha = 3, mu = 3 }, lowest_order = 3, highest_order = 4 }
[report]
figures = ["svg"]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A finished run, with its report."""
    made = tmp_path_factory.mktemp("searches")
    (made / "searched.toml").write_text(CONFIG)
    ecfit.run(made / "searched.toml", made / "results", workers=1)
    return made


@pytest.fixture(scope="module")
def study(folder):
    return load(folder / "searched.toml", folder / "results")


def test_budgets_share_one_search_a_seed(folder, study):
    files = sorted((folder / "results/searched/searches").iterdir())
    seeds = [json.loads(f.read_text()) for f in files]
    assert sorted(s["seed"] for s in seeds) == [0, 1]
    ((form, found),) = study.searches["conductor"]
    assert form == "corner-selected"
    for choice in found:
        errors = [f["objective"] for s in seeds for f in s["found"] if len(f["coefficients"]) == choice.count]
        assert choice.objective == min(errors)


def test_the_fits_have_the_terms_that_were_found(study):
    fits = {f.approximation.count: f for f in study.fits["conductor"]}
    assert sorted(fits) == [3, 4]
    ((_, found),) = study.searches["conductor"]
    for choice in found:
        if choice.count in fits:
            structure = fits[choice.count].approximation.formula.structure
            assert structure.to_dict() == choice.structure.to_dict()


def test_the_front_is_written(folder):
    rows = list(csv.DictReader((folder / "results/searched/searches.csv").read_text().splitlines()))
    assert [int(r["coefficients"]) for r in rows] == sorted(int(r["coefficients"]) for r in rows)
    cheapest = min(rows, key=lambda r: float(r["cost"]))
    assert cheapest["front"] == "yes"
    assert (folder / "results/searched/figures/conductor-searches.svg").exists()


@pytest.mark.usefixtures("no_report")
def test_what_is_gone_or_damaged_is_searched_again(folder):
    results = folder / "results/searched"
    files = sorted((results / "searches").iterdir())
    before = [f.read_bytes() for f in files]
    fits = {f: f.read_bytes() for f in sorted((results / "fits").iterdir())}
    files[0].write_text("{}")
    for f in fits:
        f.unlink()
    study = ecfit.run(folder / "searched.toml", folder / "results", workers=1)
    assert sum(what.startswith("search ") for what in study.seconds) == 1
    assert [f.read_bytes() for f in files] == before
    assert {f: f.read_bytes() for f in fits} == fits


def test_whatever_changes_a_search_changes_its_key(folder):
    def keys(text: str) -> set[str]:
        path = folder / "other.toml"
        path.write_text(text)
        return {s.key for s in make_plan(read_config(path), folder).searches}

    first = keys(CONFIG)
    assert len(first) == 2
    assert first < keys(CONFIG.replace("seeds = 2", "seeds = 3"))
    for old, new in (
        ("rounds = 2", "rounds = 3"),
        ("rounds = 2", "rounds = 2\nprice = 0.01"),
        ("rounds = 2", "rounds = 2\nrounding = 1e-6"),
        ("[3, 4]", "[3, 5]"),
        ("lowest_order = 3, highest_order = 4", "lowest_order = 3, highest_order = 5"),
        ("count = 6", "count = 7"),
    ):
        assert not first & keys(CONFIG.replace(old, new))
