"""The search finds a planted form, repeatably, and its books are in order."""

import numpy as np
import pytest

from ecfit.fitting.search import Search
from ecfit.fitting.selection import Plan, located, select, structures, to_json
from ecfit.forms import Structure


def planted(mu):
    return (0.7 + 0.4 * mu**3) / (1.0 + 2.0 * mu**2)


@pytest.fixture(scope="module")
def problem(curve):
    return curve(planted)


@pytest.fixture(scope="module")
def searches(problem) -> list[Search]:
    return [select(problem.descent, Plan((3, 4), rounds=4, repetitions=1, seed=seed)) for seed in (0, 0, 1)]


def test_a_planted_form_is_found(searches):
    for search in searches:
        assert search.best[3].rms < 1e-5
        assert sorted(search.best[3].support[0]) == [0, 3]
        assert {search.best[3].leading, *search.best[3].support[1]} == {0, 2}


def test_one_seed_gives_one_result(searches):
    first, again, _ = searches
    assert first.fits == again.fits
    assert first.best.keys() == again.best.keys()
    for count, found in first.best.items():
        other = again.best[count]
        assert (found.support, found.leading) == (other.support, other.leading)
        np.testing.assert_array_equal(found.coefficients, other.coefficients)


def test_every_result_has_as_many_coefficients_as_its_key_says(problem, searches):
    for search in searches:
        for count, found in search.best.items():
            assert found.count == count == len(found.coefficients)
            assert found.leading not in found.support[-1]
            assert all(len(set(s)) == len(s) for s in found.support)
            rms = problem.descent.rms([list(s) for s in found.support], found.leading, found.coefficients)
            assert rms == pytest.approx(found.rms, rel=1e-6, abs=1e-12)


def test_what_was_found_reads_back(problem, searches):
    made = structures(problem.structure, searches[0])
    written = to_json(problem.structure, searches[0])
    assert [w["count"] for w in written] == sorted(made) == [s.count for s, _, _ in made.values()]
    for entry in written:
        again = Structure.from_dict(entry["structure"])
        found = searches[0].best[entry["count"]]
        assert located(problem.structure, again) == ([list(s) for s in found.support], found.leading)


def test_a_merged_search_is_the_better_of_both(problem, searches):
    merged = Search(problem.descent)
    merged.merge(searches[0])
    merged.merge(searches[2])
    for count in merged.best:
        both = [s.best[count].objective for s in (searches[0], searches[2]) if count in s.best]
        assert merged.best[count].objective == min(both)


def test_a_negative_target_is_searched_too(curve):
    found = select(curve(lambda mu: -planted(mu)).descent, Plan((3,), rounds=0, repetitions=1))
    assert found.best[3].rms < 1e-5


def test_forms_whose_denominator_vanishes_are_none(problem):
    """mu + c mu^2 is 0 at the first node whatever c: nothing is found there, and nothing remembered."""
    search = Search(problem.descent)
    assert search.fit([[0], [2]], 1, np.array([1.0, 1.0])) is None
    assert search.best == {}
