"""The report: self-contained, escaped, deterministic; figures of any dimension."""

import dataclasses
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import ecfit
from ecfit import report
from ecfit.config import StudyConfig
from ecfit.forms import Minimum
from ecfit.report.inline import inline
from ecfit.report.style import rendered


@pytest.mark.parametrize("counts", [(9,), (9, 8), (6, 7, 8)])
def test_every_figure_draws_tables_of_one_to_three_dimensions(make_smooth, counts: tuple[int, ...]):
    table = make_smooth(*counts)
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


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_figures_are_byte_identical(make_smooth, kind: str):
    table = make_smooth(9, 8)
    fits = [ecfit.fit(table, ecfit.Polynomial(1))]
    once, twice = (rendered(report.error_maps("t", table, fits), kind) for _ in range(2))
    assert once == twice


def test_an_unusable_fit_is_marked_in_the_figure(make_smooth):
    table = make_smooth(9, 8)
    fit = ecfit.fit(table, ecfit.Polynomial(1))
    bad = dataclasses.replace(fit, status="pole", smallest=Minimum(-1.0, (0.0, 0.0), -1.0))
    assert "pole" in rendered(report.degree_vs_error("t", table, [bad]), "svg").decode()
    assert "HAS A POLE" in bad.warning()


def test_the_page_is_self_contained_and_well_formed(solid):
    page = solid.report.read_text()
    assert len(page) < 300_000
    outside = re.findall(
        r'(?:src|href)="(?!#|data:)[^"]*', page.replace("xlink:href", "href").replace("\n", " ")
    )
    assert outside == []
    assert "@import" not in page
    assert not re.findall(r"url\((?!#)", page)
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    for used in re.findall(r'url\(#([^)]+)\)|href="#([^"]+)"', page):
        assert (used[0] or used[1]) in ids
    for word in ("Verdict", "printed-2022", "table-5x6x7", "Contract", "SPDX-License-Identifier"):
        assert word in page


def test_labels_keep_their_digits_where_paths_lose_theirs():
    svg = b'<svg><path d="M 1.23456 0"/><text>F0 = 0.0125</text></svg>'
    element = inline(svg, "p", "a figure")
    assert 'd="M 1.23 0"' in element
    assert "<text>F0 = 0.0125</text>" in element


def test_a_page_follows_the_scheme_of_its_reader(solid):
    """Figures have no colours of paper and ink of their own, and neither style sheets."""
    page = solid.report.read_text()
    figures = re.findall(r"<svg.*?</svg>", page, re.S)
    assert len(figures) == 3
    for svg in figures:
        ElementTree.fromstring(svg)
        assert not re.findall(r"#ffffff|#000000|#111111|<style", svg, re.I)
        assert re.search(r'class="z\d+"', svg)
    assert re.search(r"\.z\d+\{[^}]*stroke: currentColor", page)
    assert re.search(r"\.z\d+\{[^}]*var\(--polynomial\)", page)


@pytest.mark.slow
def test_pages_are_byte_identical(solid, tmp_path: Path):
    again = dataclasses.replace(solid, folder=tmp_path)
    report.write_report(again)
    old, new = (
        {p.relative_to(study.folder): p.read_bytes() for p in study.folder.rglob("*") if p.is_file()}
        for study in (solid, again)
    )
    assert len(old) == 9
    assert new == old


def test_files_of_figures_are_what_the_config_asks_for(solid):
    found = {p.name for p in (solid.folder / "figures").iterdir()}
    kinds = ("best-fit", "degree-vs-error", "error-against-cost", "error-along-axes", "error-maps", "table")
    assert found == {f"e-{kind}.svg" for kind in kinds}
    markdown = (solid.folder / "report.md").read_text()
    for name in found:
        assert f"(figures/{name})" in markdown
    # A paper's figure is dark on white, whatever the page does with its own copy.
    assert "#ffffff" in (solid.folder / "figures/e-table.svg").read_text()


def without_files(study: ecfit.Study) -> StudyConfig:
    """The study's config, asking for no files of figures."""
    kinds = study.config.report.model_copy(update={"figures": []})
    return study.config.model_copy(update={"report": kinds})


HOSTILE = "</script><script>alert(1)</script>\"'&"


def test_text_from_outside_is_escaped(solid, tmp_path: Path):
    """A model, an approximation, a source and a study's warning may say anything."""
    table = solid.tables["e"]
    contract = dataclasses.replace(table.contract, model=HOSTILE, options={"ndf": HOSTILE})
    provenance = {**table.provenance, "source": HOSTILE}
    hostile = dataclasses.replace(table, contract=contract, provenance=provenance)
    published = [(dataclasses.replace(a, name=HOSTILE), e) for a, e in solid.published["e"]]
    fits = [
        dataclasses.replace(
            f, approximation=dataclasses.replace(f.approximation, name=HOSTILE), status="pole"
        )
        for f in solid.fits["e"][:1]
    ] + solid.fits["e"][1:]
    other = dataclasses.replace(
        solid, folder=tmp_path, tables={"e": hostile}, published={"e": published}, fits={"e": fits},
        config=without_files(solid),
    )  # fmt: skip
    report.write_report(other)
    page = other.report.read_text()
    assert page.count("alert(1)") > 5
    assert "<script>alert" not in page
    assert page.count("<script") == solid.report.read_text().count("<script") == page.count("</script>")
    for shown in (hostile, other, *fits, *(a for a, _ in published)):
        assert "<script>" not in shown._repr_html_()


@pytest.mark.slow
def test_a_study_without_a_usable_fit_says_so(solid, tmp_path: Path):
    bad = [dataclasses.replace(f, status="not-converged") for f in solid.fits["e"]]
    config = without_files(solid)
    study = dataclasses.replace(solid, folder=tmp_path, fits={"e": bad}, config=config)
    report.write_report(study)
    page = study.report.read_text()
    assert "No usable fit: " in page
    assert "DID NOT CONVERGE" in page
    assert "not-converged" in study.report.with_suffix(".md").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("counts", [(9,), (9, 8), (4, 3, 5, 6)])
def test_tables_of_any_dimension_have_a_page(solid, make_smooth, tmp_path: Path, counts: tuple[int, ...]):
    names = ("x", "F0", "r", "mu")[4 - len(counts) :]
    axes = tuple(ecfit.Axis.spaced(n, c) for n, c in zip(names, counts, strict=True))
    values = np.asarray(1.0 / (1.0 + sum(np.meshgrid(*[a.nodes for a in axes], indexing="ij"))))
    zeros = np.zeros_like(values)
    table = ecfit.Table(values, zeros, zeros, axes, ecfit.Contract("synthetic"), 1e-8)
    fits = [ecfit.fit(table, ecfit.Polynomial(1))]
    study = dataclasses.replace(
        solid, folder=tmp_path, tables={"e": table}, fits={"e": fits}, published={"e": []},
        config=without_files(solid),
    )  # fmt: skip
    report.write_report(study)
    page = study.report.read_text()
    assert page.count('<input type="range"') == max(0, len(counts) - 2)
    assert ("Signed error" in page) == (len(counts) > 1)


def test_figures_are_of_a_size_for_print(make_smooth):
    table = make_smooth(9, 8)
    figure = report.table_and_fit("t", table, ecfit.fit(table, ecfit.Polynomial(1)))
    assert isinstance(figure, Figure)
    png = rendered(figure, "png")
    assert int.from_bytes(png[16:20], "big") >= 1900  # pixels across
