"""What a study judges beside its fits: published formulas in other views, and look-up tables."""

import csv
from pathlib import Path

import pytest

import ecfit
from ecfit.config import read_config
from ecfit.study.plan import make_plan

CONFIG = """name = "small"
[[tables]]
name = "f"
model = "dielectric"
quantity = "average-fresnel"
axes = { F0 = { count = 9, low = 0.01, high = 0.2 } }
tolerance = 1e-6
[[fits]]
tables = ["f"]
form = "polynomial"
degree = 1
[[compare]]
tables = ["f"]
published = ["deon-average-fresnel", "osl-average-fresnel"]
shipped = ["average-fresnel-4"]
lookups = [
  { counts = { F0 = 5 }, through = { F0 = "fourth-power" } },
  { counts = { ior = 4 } },
]
[report]
figures = ["svg"]
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ecfit.Study]:
    """(folder of config and results, study), run once."""
    folder = tmp_path_factory.mktemp("compare")
    (folder / "small.toml").write_text(CONFIG)
    return folder, ecfit.run(folder / "small.toml", folder / "results", workers=1)


def test_formulas_and_tables_have_a_row_each(finished):
    folder, _ = finished
    rows = list(csv.DictReader((folder / "results/small/summary.csv").read_text().splitlines()))
    assert [(r["form"], r["coefficients"], r["status"]) for r in rows[1:]] == [
        ("deon-average-fresnel", "4", "published"),
        ("osl-average-fresnel", "2", "published"),
        ("average-fresnel-4", "4", "shipped"),
        ("table-5-F0-fourth-power", "5", "table"),
        ("table-4", "4", "table"),
    ]
    assert float(rows[1]["mae"]) < float(rows[2]["mae"])


@pytest.mark.usefixtures("no_report")
def test_tables_lie_with_the_others_and_are_computed_once(finished):
    folder, study = finished
    assert len(list((folder / "results/tables").glob("*.npz"))) == 3
    assert "table f as table-4" in study.seconds
    again = ecfit.run(folder / "results/small/config.toml", folder / "results")
    assert again.seconds == {}
    loaded = ecfit.study.load(folder / "small.toml", folder / "results")
    assert [(a.name, e) for a, e in loaded.published["f"]] == [(a.name, e) for a, e in study.published["f"]]


def test_the_report_tells_tables_from_formulas(finished):
    folder, _ = finished
    text = (folder / "results/small/report.md").read_text()
    assert "| table-4 | 4 |" in text
    assert text.count("| published |") == 2
    assert text.count("| table |") == 2
    assert text.count("| shipped |") == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("{ ior = 4 }", "{ mu = 4 }", "table 'f': no axis stands for 'mu': expected one of F0"),
        ('"osl-average-fresnel"', '"kulla-conty-2017"', "function of r, mu, the table of F0"),
        ('{ F0 = "fourth-power" }', '{ mu = "square" }', "through names 'mu', which is not in counts"),
        ('{ F0 = "fourth-power" }', '{ F0 = "cube" }', "expected one of identity"),
        ("{ ior = 4 }", "{ ior = 1 }", "greater than or equal to 2"),
        ("average-fresnel-4", "average-fresnel-3", "unknown shipped fit 'average-fresnel-3'"),
        ("average-fresnel-4", "conductor-10", "function of mu, alpha, the table of F0"),
        ('published = ["deon-average-fresnel", "osl-average-fresnel"]', "published = []", "at least 1 item"),
    ],
)
def test_what_cannot_be_compared_is_told(tmp_path: Path, old: str, new: str, message: str):
    assert old in CONFIG
    path = tmp_path / "bad.toml"
    path.write_text(CONFIG.replace(old, new, 1))
    with pytest.raises(ecfit.EcfitError, match=message):
        make_plan(read_config(path), tmp_path)


def test_a_comparison_with_nothing_is_told(tmp_path: Path):
    path = tmp_path / "bad.toml"
    path.write_text(CONFIG[: CONFIG.index("published =")] + CONFIG[CONFIG.index("[report]") :])
    with pytest.raises(ecfit.EcfitError, match="give published, shipped or lookups"):
        read_config(path)


def test_a_table_from_a_file_has_no_lookups(tmp_path: Path):
    (tmp_path / "t.csv").write_text("\n".join(["0.1", "0.2", "0.3"] * 3))
    table = CONFIG[CONFIG.index("[[tables]]") : CONFIG.index("[[fits]]")]
    text = CONFIG.replace(
        table, '[[tables]]\nname = "f"\nfile = "t.csv"\naxes = { F0 = 9 }\nquantity = "average-fresnel"\n'
    )
    (tmp_path / "bad.toml").write_text(text)
    with pytest.raises(ecfit.EcfitError, match="is read from a file"):
        make_plan(read_config(tmp_path / "bad.toml"), tmp_path)
