"""The report: self-contained, escaped, deterministic; figures of any dimension."""

import dataclasses
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit import report
from ecfit.forms import Minimum
from ecfit.report.style import rendered


def synthetic(*counts: int) -> ecfit.Table:
    """A smooth table on axes mu, r, x, ... in [0, 1]."""
    names = ("r", "mu", "x")[: len(counts)]
    axes = tuple(ecfit.Axis.spaced(n, c) for n, c in zip(names, counts, strict=True))
    mesh = np.meshgrid(*[a.nodes for a in axes], indexing="ij")
    values = np.asarray(1.0 / (1.0 + sum(mesh)))
    zeros = np.zeros_like(values)
    return ecfit.Table(values, zeros + 1e-9, zeros, axes, ecfit.Contract("synthetic"), 1e-8)


@pytest.mark.parametrize("counts", [(9,), (9, 8), (6, 7, 8)])
def test_every_figure_draws_tables_of_one_to_three_dimensions(counts: tuple[int, ...]):
    table = synthetic(*counts)
    fits = [ecfit.fit(table, ecfit.Polynomial(d)) for d in (1, 2)]
    for figure in (
        report.degree_vs_error("t", table, fits),
        report.table_and_fit("t", table, fits[1]),
        report.error_maps("t", table, fits),
        report.error_along_axes("t", table, fits),
    ):
        svg = rendered(figure, "svg")
        ElementTree.fromstring(svg)
    assert rendered(figure, "png").startswith(b"\x89PNG")


def test_figures_are_byte_identical():
    table = synthetic(9, 8)
    fits = [ecfit.fit(table, ecfit.Polynomial(1))]
    once, twice = (rendered(report.error_maps("t", table, fits), "svg") for _ in range(2))
    assert once == twice


def test_an_unusable_fit_is_marked_in_the_figure():
    table = synthetic(9, 8)
    fit = ecfit.fit(table, ecfit.Polynomial(1))
    bad = dataclasses.replace(fit, status="pole", smallest=Minimum(-1.0, (0.0, 0.0), -1.0))
    assert "pole" in rendered(report.degree_vs_error("t", table, [bad]), "svg").decode()
    assert "HAS A POLE" in bad.warning()


CONFIG = """
name = "page"
[[tables]]
name = "e"
model = "lambertian"
axes = { rho = 6, mu = 6 }
[[fits]]
tables = ["e"]
form = "polynomial"
degree = [1, 2]
[report]
figures = []
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> ecfit.Study:
    folder = tmp_path_factory.mktemp("page")
    (folder / "page.toml").write_text(CONFIG)
    return ecfit.run(folder / "page.toml", folder)


def test_the_page_is_self_contained_and_well_formed(study):
    page = study.report.read_text()
    assert len(page) < 1_000_000
    assert page.count("<svg") == 5
    assert not re.findall(r'(?:src|href)="(?!#|data:)', page.replace("xlink:href", "href").replace("\n", " "))
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    for used in re.findall(r'url\(#([^)]+)\)|href="#([^"]+)"', page):
        assert (used[0] or used[1]) in ids
    assert "polynomial" in page
    assert "Contract" in page


def test_text_from_outside_is_escaped(study, tmp_path: Path):
    table = study.tables["e"]
    contract = dataclasses.replace(table.contract, model="<script>alert(1)</script>")
    hostile = dataclasses.replace(table, contract=contract)
    other = dataclasses.replace(study, folder=tmp_path, tables={"e": hostile})
    report.write_report(other)
    assert "<script>" not in other.report.read_text()
    assert "&lt;script&gt;" in other.report.read_text()
