"""The search finds a planted form, repeatably, and its books are in order."""

import itertools
import json

import numpy as np
import pytest

import ecfit
from ecfit.approximation import StructuredFormula
from ecfit.errors import EcfitError
from ecfit.expressions import value
from ecfit.fitting.search import Search
from ecfit.fitting.selection import Choice, choices, first_form, front, merged, select
from ecfit.forms.candidates import Powers, chosen


def planted(mu):
    return (0.7 + 0.4 * mu**3) / (1.0 + 2.0 * mu**2)


@pytest.fixture(scope="module")
def problem(curve):
    return curve(planted)


@pytest.fixture(scope="module")
def form(problem):
    bounds = Powers({"mu": len(problem.structure.denominator) - 1})
    made = ecfit.Selected("ratio", ("mu",), [bounds], bounds, budget=3, budgets=(3, 4), rounds=4)
    assert made.whole.to_dict() == problem.structure.to_dict()
    return made


@pytest.fixture(scope="module")
def searches(problem, form) -> list[list[Choice]]:
    return [select(problem.descent, form, seed) for seed in (0, 0, 1)]


def test_a_planted_form_is_found(searches):
    for found in searches:
        (three,) = (c for c in found if c.count == 3)
        assert three.rms < 1e-5
        assert sorted(three.structure.numerators[0].ravel().tolist()) == [0.0, 3.0]
        assert set(three.structure.denominator.ravel().tolist()) == {0.0, 2.0}


def test_one_seed_gives_one_result(searches):
    first, again, _ = searches
    assert [c.to_dict() for c in first] == [c.to_dict() for c in again]


def test_every_result_has_as_many_coefficients_as_its_key_says(problem):
    search = Search(problem.descent)
    rng = np.random.default_rng(0)
    search.grow(first_form(search), 4, rng)
    search.explore(3, rng, 5)
    for count, found in search.best.items():
        assert found.count == count == len(found.coefficients)
        assert found.leading not in found.support[-1]
        assert all(len(set(s)) == len(s) for s in found.support)
        rms = problem.descent.rms(found.chosen, found.leading, found.coefficients)
        assert rms == pytest.approx(found.rms, rel=1e-6, abs=1e-12)
    assert [c.count for c in choices(problem.structure, search)] == sorted(search.best)


def test_another_leading_term_is_the_same_form(problem):
    search = Search(problem.descent)
    rng = np.random.default_rng(0)
    search.grow(first_form(search), 4, rng)
    found = search.best[4]
    value = problem.descent.value(found.chosen, found.leading, found.coefficients)[0]
    for heir in range(len(found.support[-1])):
        led = found.led_by(heir)
        assert led.leading == found.support[-1][heir]
        assert led.count == found.count
        other = problem.descent.value(led.chosen, led.leading, led.coefficients)[0]
        np.testing.assert_allclose(other, value, rtol=1e-9)


def test_operations_have_a_price(curve):
    """Of two forms of one size, the dearer has to be better by its price."""
    descent = curve(lambda mu: np.exp(-2.0 * mu)).descent

    def operations(support, leading):
        return 1e6 if 3 in support[0] else 0.0

    searches = [Search(descent, operations=operations, price=price) for price in (0.0, 1.0)]
    errors = {}
    for search in searches:
        for column in (1, 3):
            found = search.fit([[0, column], [2]], 0, np.array([1.0, 0.1, 1.0]))
            assert found is not None
            errors[column] = found.objective
    better = min(errors, key=errors.__getitem__)
    assert better in searches[0].best[3].support[0]
    assert max(errors.values()) < 1e6 * min(errors.values())
    assert 1 in searches[1].best[3].support[0]


def test_a_form_that_loses_too_much_in_single_precision_counts_as_worse(problem):
    """The same descent with and without a limit; the estimate covers what single precision loses."""
    free = Search(problem.descent)
    free.grow(first_form(free), 5, np.random.default_rng(0))
    found = free.best[5]
    lost = problem.descent.rounding(found.chosen, found.leading, found.coefficients)
    formula = StructuredFormula(
        chosen(problem.structure, found.chosen, found.leading), np.asarray(found.coefficients)
    )
    variable = problem.table.axes[0].name
    points = {variable: np.random.default_rng(1).uniform(0.05, 1.0, 2000).astype(np.float32)}
    wide = {variable: points[variable].astype(np.float64)}
    expression = formula.expression((variable,))
    measured = np.max(np.abs(value(expression, points).astype(np.float64) - value(expression, wide)))
    assert 0.1 * measured < lost < 10.0 * measured
    for limit, factor in ((2.0 * lost, 1.0), (lost / 4.0, 2.0)):
        held = Search(problem.descent, rounding=limit)
        again = held.fit(found.chosen, found.leading, found.coefficients)
        assert again is not None
        assert again.objective / again.rms == pytest.approx(factor * found.objective / found.rms, rel=0.05)


def test_what_was_found_reads_back(problem, searches):
    for choice in searches[0]:
        again = Choice.from_dict(json.loads(json.dumps(choice.to_dict())))
        assert again.to_dict() == choice.to_dict()
        formula = StructuredFormula(again.structure, again.coefficients)
        error = formula.value([problem.table.axes[0].nominal]) - problem.table.values
        rms = np.linalg.norm(error * problem.descent.root_w)
        assert rms == pytest.approx(choice.rms, rel=1e-6, abs=1e-12)


def test_merged_keeps_the_best_and_the_front_only_what_is_not_beaten(searches):
    best = merged(searches)
    for choice in best:
        of_size = [c.objective for found in searches for c in found if c.count == choice.count]
        assert choice.objective == min(of_size)
    line = front(best)
    assert {id(c) for c in line} <= {id(c) for c in best}
    for cheaper, dearer in itertools.pairwise(line):
        assert dearer.cost.total >= cheaper.cost.total
        assert dearer.objective < cheaper.objective
    for choice in best:
        assert any(c.objective <= choice.objective and c.cost.total <= choice.cost.total for c in line)


def test_a_search_without_a_positive_denominator_says_so(curve):
    found = curve(planted)
    descent = found.descent
    for table in (descent.columns[-1], descent.guard_columns[-1]):
        table *= -1.0
    with pytest.raises(EcfitError, match="no start of the search has a positive denominator"):
        first_form(Search(descent))
