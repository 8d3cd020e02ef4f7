"""Study files: whatever one holds, planning it ends, writes nothing, and imports only plugins it names."""

import json
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import OUTSIDE, changed, changes, guarded, many, settled, tried
from hypothesis import strategies as st

import ecfit
from ecfit.config import read_config, to_toml
from ecfit.study.fits import fit_path
from ecfit.study.plan import make_plan
from ecfit.study.runner import table_path

# Every section, key and form that a study may have.
GOOD = """
name = "all"
[[tables]]
name = "e"
model = "dielectric"
options = { masking = "separable", side = "entering" }
axes = { F0 = { count = 8, low = 0.02, high = 0.2 }, r = 12, mu = { count = 12, spacing = "gauss" } }
tolerance = 1e-6
[[tables]]
name = "theirs"
file = "theirs.csv"
options = { what = "theirs" }
stored = "1-E"
scale = 2.0
order = ["mu", "-r"]
axes = { r = 6, mu = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] }
[[tables]]
name = "b"
model = "conductor"
options = { fresnel = "schlick", F0 = 0.5 }
quantity = "schlick-b"
quantity_options = { exponent = 6 }
lobe = "reflection"
axes = { r = 8, mu = { count = 8, through = "square" } }
[[fits]]
tables = ["e", "b"]
form = "polynomial"
degree = [1, 2]
norm = "l4"
[[fits]]
tables = ["b"]
form = "rational"
numerator = [1, 2]
denominator = 1
guarded = false
digits = 7
ridge = 1e-9
weights = { mu = 1.0 }
[[fits]]
tables = ["b"]
name = "terms"
form = "structured"
head = "ratio"
features = ["alpha", "mu"]
terms = { numerators = [[[0.0, 0.0], [1.0, 0.0]]], denominator = [[0.0, 0.0], [0.0, 1.0]] }
start = [0.5, 0.1, 0.2]
strength = 2.0
margin = 1e-4
[[fits]]
tables = ["b"]
name = "found"
form = "selected"
head = { name = "mine", factors = [{ alpha = 1.0 }], text = "1 - X" }
features = ["alpha", "mu"]
within.numerators = [{ highest = { alpha = 2, mu = 2 } }]
within.denominator = { highest = { alpha = 1, mu = 1 } }
budget = 4
rounds = 3
seeds = 2
price = 0.1
[[fits]]
tables = ["theirs"]
name = "own"
form = "module"
module = "written"
settings = { variables = ["r", "mu"], formula = "1-a*r*q", let = [["q", "1-mu"]], constants = { a = 0.5 } }
[[fits]]
tables = ["b"]
name = "whole"
form = "composed"
text = "min(x, 1)"
parts = { x = "terms" }
[[compare]]
tables = ["e"]
lookups = [{ counts = { F0 = 4, r = 4, mu = 4 }, through = { mu = "square" } }]
[report]
figures = ["svg"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    r, mu = np.meshgrid(*[np.linspace(0.0, 1.0, 6)] * 2)
    np.savetxt(tmp_path / "theirs.csv", r * mu, delimiter=",")
    # A plugin that nobody names: importing it would be seen.
    (tmp_path / "unnamed_plugin.py").write_text("raise SystemExit('imported')\n")
    return tmp_path


def plan(path: Path) -> None:
    """Read and resolve; every file that a run would write is inside the results folder."""
    found = make_plan(read_config(path), path.parent)
    results = (path.parent / "results").resolve()
    inside = results / found.config.name
    assert inside.resolve().parent == results
    for fit in found.fits:
        assert fit_path(fit, inside).resolve().parent == inside / "fits"
    for request in found.requests.values():
        assert table_path(request, results).resolve().parent == results / "tables"
    for name in found.requests:
        assert (inside / "figures" / f"{name}-table.svg").resolve().parent == inside / "figures"


def written(path: Path, data: Any) -> bool:
    """Write as TOML what can be; TOML has no null, and its strings no lone surrogates."""
    try:
        path.write_text(to_toml(data), encoding="utf-8")
        tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeEncodeError, AttributeError, TypeError):
        return False
    return True


def test_the_good_study_is_planned(folder: Path):
    (folder / "study.toml").write_text(GOOD)
    assert settled(lambda: plan(folder / "study.toml"))


@many(60, 1500)
def test_a_changed_study_is_planned_or_an_error(folder: Path, cases: int):
    path, good = folder / "study.toml", tomllib.loads(GOOD)
    loaded = {name for name in sys.modules if name.startswith("ecfit_plugin")}
    reached = 0

    def case(made: list[Any]) -> None:
        nonlocal reached
        if written(path, changed(good, made)):
            reached += 1
            settled(lambda: plan(path))

    with guarded(folder):
        tried(cases, changes, case)
    assert reached > cases // 2
    assert {name for name in sys.modules if name.startswith("ecfit_plugin")} == loaded
    assert sorted(p.name for p in folder.iterdir()) == ["study.toml", "theirs.csv", "unnamed_plugin.py"]


@pytest.mark.parametrize("name", ["../../escaped", OUTSIDE, "a/b", "a\\b", "a\nb", "a\0b", "..", ""])
@pytest.mark.parametrize("old", ['name = "all"', 'name = "e"', 'name = "terms"', 'name = "mine"'])
def test_no_name_leads_out_of_the_results_folder(folder: Path, old: str, name: str):
    """Of studies, tables, fits and heads: files are named after them."""
    path = folder / "study.toml"
    text = GOOD.replace(old, f"name = {json.dumps(name)}").replace('name = "found"\n', "")
    assert text.count(json.dumps(name)) == 1
    path.write_text(text)
    harmless = "mine" in old and name in ("..", "")  # b-..-selected-4 is a name like any other
    assert settled(lambda: plan(path)) == harmless


def test_a_plugin_is_imported_only_where_it_is_named(folder: Path):
    (folder / "mine.py").write_text("import pathlib\npathlib.Path(__file__).with_name('ran').touch()\n")
    path = folder / "study.toml"
    path.write_text(GOOD)
    plan(path)
    assert not (folder / "ran").exists()
    path.write_text('plugins = ["mine.py"]\n' + GOOD)
    plan(path)
    assert (folder / "ran").exists()


def test_a_plugin_that_leaves_is_told(folder: Path):
    path = folder / "study.toml"
    path.write_text('plugins = ["unnamed_plugin.py"]\n' + GOOD)
    with pytest.raises(ecfit.EcfitError, match=r"plugin 'unnamed_plugin.py'"):
        plan(path)


@many(15, 300)
def test_plugins_that_cannot_be_imported_are_errors(folder: Path, cases: int):
    path = folder / "study.toml"
    names = st.text(st.sampled_from(".\\/abé\x00\n -"), max_size=8)

    def case(name: str) -> None:
        if written(path, {"plugins": [name], **tomllib.loads(GOOD)}):
            assert not settled(lambda: plan(path))

    with guarded(folder):
        tried(cases, st.one_of(names, names.map(lambda n: n + ".py")), case)
