"""What objects show of themselves, as text and in notebooks."""

import dataclasses
import xml.etree.ElementTree as ElementTree

import pytest

import ecfit
from ecfit.display import facts, grid


@pytest.fixture(scope="module")
def table(make_table, unit_axis) -> ecfit.Table:
    return make_table(lambda r, mu: 0.5 + 0.1 * r * mu, unit_axis("r", 6), unit_axis("mu", 5))


@pytest.fixture(scope="module")
def fit(table) -> ecfit.Fit:
    return ecfit.fit(table, ecfit.Polynomial(2))


def test_every_text_is_escaped_and_the_markup_is_well_formed():
    hostile = "<img src=x onerror=alert(1)>&\"'"
    for text in (
        facts(hostile, [(hostile, hostile)], hostile),
        grid(hostile, [hostile], [[hostile]], [hostile]),
    ):
        assert "<img" not in text
        tree = ElementTree.fromstring(text)
        assert "".join(tree.itertext()) == hostile * 4


def test_a_table_says_what_it_holds(table):
    assert repr(table) == "<Table of directional-albedo of unknown: r 6 x mu 5, in [0.5, 0.6], error <= 0>"
    assert str(table).splitlines() == table.describe()
    for word in ("6 x 5 entries", "separable" if "separable" in table.contract.options else "transport"):
        assert word in table._repr_html_()


def test_a_fit_says_how_good_it_is(fit):
    assert repr(fit).startswith("<Fit polynomial 2: 6 coefficients, RMSE ")
    assert repr(fit).endswith(", converged>")
    assert "MAE" in str(fit)
    assert "WARNING" not in str(fit)
    assert "6 coefficients, converged" in fit._repr_html_()


def test_a_fit_that_may_not_be_used_warns_wherever_it_is_shown(fit):
    bad = dataclasses.replace(fit, status="not-converged")
    assert "not-converged" in repr(bad)
    assert "WARNING: polynomial 2 DID NOT CONVERGE" in str(bad)
    assert "DID NOT CONVERGE" in bad._repr_html_()


def test_an_approximation_says_what_of_and_where():
    found = ecfit.published("kulla-conty-2017")
    assert repr(found).startswith("<Approximation kulla-conty-2017: ")
    assert "mu in [0, 1]" in repr(found)
    assert found.source.split("&")[0].strip()[:10] in found._repr_html_()


def test_a_study_shows_its_verdict_and_its_fits(solid):
    study = solid
    assert repr(study).startswith("<Study page: 1 tables, 2 fits, in ")
    assert "Best fit of the study: polynomial 2" in str(study)
    page = study._repr_html_()
    ElementTree.fromstring(page)
    assert page.count("<tr>") == 3
