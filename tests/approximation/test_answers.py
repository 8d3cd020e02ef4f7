"""docs/published-fits.md: every printed fit is on it, with an answer that is no larger."""

import sys
from pathlib import Path

import pytest

import ecfit
from ecfit.approximation import published_names

ROOT = Path(__file__).parent.parent.parent
PAGE = (ROOT / "docs" / "published-fits.md").read_text()


@pytest.fixture(scope="module")
def answers():
    """benchmarks/answers.py."""
    pytest.importorskip("matplotlib", reason="the benchmarks draw figures")
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        import answers  # pyright: ignore[reportMissingImports]
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))
    return answers


def part(title: str) -> str:
    return PAGE.split(f"<!-- begin: {title},")[1].split(f"<!-- end: {title} -->")[0]


@pytest.mark.parametrize("title", ["formulas", "answers"])
def test_every_printed_fit_is_on_the_page(title):
    missing = [name for name in published_names() if f"| `{name}`" not in part(title)]
    assert missing == []


def test_every_answer_has_no_more_numbers(answers):
    for name, entries in answers.entries().items():
        printed = ecfit.published(name)
        for entry in entries:
            if "no" not in entry:
                assert answers.Answer.of(entry).count <= printed.count, name


def test_what_costs_more_is_said(answers):
    """No answer takes functions of a dearer kind unless the page says so."""
    lines = part("answers").splitlines()
    for name, entries in answers.entries().items():
        printed = answers.dearest(answers.cost(ecfit.published(name).expression()))
        dearer = [
            answers.dearest(answers.cost(answers.Answer.of(e).root)) > printed
            for e in entries
            if "no" not in e
        ]
        said = ["dearer functions" in line for line in lines if line.startswith(f"| `{name}`")]
        assert said[: len(dearer)] == dearer, name


def test_all_but_one_are_answered_by_half_the_errors():
    """Of those that have an error and a number; open: radiance that leaves a dielectric."""
    lines = [line.split("|") for line in part("answers").splitlines() if line.startswith("| `")]
    best: dict[str, bool] = {}
    for line in lines:
        name, claim = line[1].split("`")[1], line[-2].strip()
        done = claim.startswith((">= ", "an exact identity", "no truth", "it has no number"))
        best[name] = best.get(name, False) or done
    assert [name for name, done in best.items() if not done] == ["sforza-pellacini-2022-dielectric-leaving"]
