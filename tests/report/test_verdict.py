"""The verdict: the best within each budget, in words, and what is proved of it."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.contract import Contract
from ecfit.forms import Terms
from ecfit.metrics import measure
from ecfit.report import verdict
from ecfit.report.entries import best, entries
from ecfit.report.verdict import Proved, choices, percentage, prover, sentences


def plain(name: str, *coefficients: float) -> ecfit.Approximation:
    """A polynomial in r."""
    terms = Terms(np.arange(len(coefficients))[:, None], np.zeros((0, 1), dtype=int))
    return ecfit.Approximation.quotient(
        name, "polynomial", str(len(coefficients) - 1), ("r",), terms, np.array(coefficients),
        ((0.0, 1.0),), Contract("unknown"), "Somebody 2020",
    )  # fmt: skip


def nothing(approximation: ecfit.Approximation) -> Proved:
    return Proved("-", "")


@pytest.fixture
def table(make_table, unit_axis) -> ecfit.Table:
    return make_table(lambda x: 0.5 + 0.25 * x + 0.1 * x**3, unit_axis("r", 16))


@pytest.fixture
def rows(table):
    """Seven numbers are worse than two, and a pole is the best of all."""
    found = [plain("two", 0.5, 0.35), plain("seven", 0.4, 0, 0, 0, 0, 0, 0), plain("four", 0.5, 0.25, 0, 0.1)]
    rows = entries(table, [], [(a, measure(a, table)) for a in found])
    return [*rows[:2], dataclasses.replace(rows[2], usable=False, status="published, pole")]


def test_each_budget_has_its_best_and_one_that_betters_nothing_is_left_out(table, rows):
    found = choices(rows, nothing, budgets=(1, 2, 10))
    assert [(c.budget, c.entry.name) for c in found] == [(2, "two")]
    more = [*rows, *entries(table, [], [(plain("x" * 3, 0.5, 0.3, 0.05), measure(plain("x", 0.5), table))])]
    better = dataclasses.replace(more[-1], errors=dataclasses.replace(rows[0].errors, rmse=1e-9))
    found = choices([*rows, better], nothing, budgets=(1, 2, 10))
    assert [(c.allowance, c.entry.count) for c in found] == [("2", 2), ("10", 3)]


def test_what_may_not_be_used_is_never_best(rows):
    assert best(rows).name == "two"
    assert best(rows[2:]) is None


def test_words_name_the_fit_its_furnace_and_the_published_rival(table):
    fit = ecfit.fit(table, ecfit.Polynomial(3))
    printed = plain("printed", 0.5, 0.35, 0.0, 0.0)
    said = sentences(entries(table, [fit], [(printed, measure(printed, table))]))
    assert said[0].startswith("Best fit of the study: polynomial 3, 4 coefficients: MAE ")
    assert "a white furnace normalised with it deviates by" in said[0]
    assert said[1].startswith("Of published approximations printed, 4 numbers, comes nearest: RMSE")
    assert "polynomial 3 (4) has one" in said[1]


def test_a_shipped_fit_is_told_after_a_published_one(table):
    fit = ecfit.fit(table, ecfit.Polynomial(1))
    ours = dataclasses.replace(plain("ours", 0.5, 0.25, 0.0, 0.1), source="ecfit")
    others = [ours, plain("printed", 0.5, 0.5)]
    rows = entries(table, [fit], [(a, measure(a, table)) for a in others])
    assert [row.status for row in rows[1:]] == ["shipped", "published"]
    assert [c.entry.name for c in choices(rows, nothing, budgets=(4,))] == ["ours"]
    said = sentences(rows)
    assert said[1].startswith("Of published approximations printed")
    assert said[2].startswith("Of the fits shipped with ecfit ours, 4 numbers, comes nearest")


def test_ratios_are_those_of_the_errors(table):
    fit = ecfit.fit(table, ecfit.Polynomial(1))
    printed = plain("printed", 0.5, 0.5)
    errors = measure(printed, table)
    said = sentences(entries(table, [fit], [(printed, errors)]))[1]
    assert f"{errors.rmse / fit.rmse:.3g} times smaller" in said


def test_other_conventions_are_said_and_not_compared(table):
    fit = ecfit.fit(table, ecfit.Polynomial(1))
    printed = dataclasses.replace(
        plain("printed", 0.5, 0.5), contract=Contract("unknown", transport="radiance")
    )
    said = sentences(entries(table, [fit], [(printed, measure(printed, table))]))[1]
    assert "was made for transport = radiance" in said
    assert "times" not in said


def test_a_table_without_fits_says_so(table):
    assert sentences(entries(table, [])) == ["No fits were asked for."]


def test_proofs_agree_with_the_certificate(tmp_path: Path):
    """Of a form that is certified, and of one whose values leave [0, 1]."""
    prove = prover(tmp_path)
    assert prove(ecfit.shipped("average-4")).word == "certified"
    found = prove(plain("beyond", 0.5, 0.75))
    assert found.word == "not certified"
    assert "values exceed 1, by 0.25" in found.why


def test_tables_and_large_formulas_are_not_proved(table, tmp_path: Path):
    prove = prover(tmp_path)
    assert prove(ecfit.Approximation.lookup(table)).word == "-"
    assert "not tried" in prove(plain("large", *np.zeros(65))).why


def test_a_proof_is_kept_and_found_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    first = prover(tmp_path)(plain("beyond", 0.5, 0.75))
    kept = json.loads((tmp_path / "proofs.json").read_text())
    assert [entry["word"] for entry in kept.values()] == ["not certified"]

    def never(approximation):
        raise AssertionError("proved twice")

    monkeypatch.setattr(verdict, "prove", never)
    assert prover(tmp_path)(plain("beyond", 0.5, 0.75)) == first
    with pytest.raises(AssertionError, match="proved twice"):
        prover(tmp_path)(plain("beyond", 0.5, 0.76))


@pytest.mark.parametrize("damage", ["{", "[]", '{"x": 1}', "null"])
def test_damaged_proofs_are_made_again(tmp_path: Path, damage: str):
    (tmp_path / "proofs.json").write_text(damage)
    assert prover(tmp_path)(plain("beyond", 0.5, 0.75)).word == "not certified"


def test_percentages_have_two_digits_and_no_exponents():
    assert [percentage(x) for x in (0.00213, 0.5, 7.3, 0.996)] == ["0.21 %", "50 %", "730 %", "100 %"]
