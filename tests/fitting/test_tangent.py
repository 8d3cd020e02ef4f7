"""The tangent of a fit: its proposals are supports whose predicted error is that of the linear problem."""

import numpy as np
import pytest

from ecfit.fitting.search import Search
from ecfit.fitting.selection import first_form
from ecfit.fitting.tangent import Tangent


@pytest.fixture(scope="module")
def found(curve):
    problem = curve(lambda mu: np.exp(-2.0 * mu) + 0.3 * mu)
    search = Search(problem.descent)
    search.grow(first_form(search), 4, np.random.default_rng(0))
    return problem.descent, search.best[4]


def proposals(found, more=0, seed=0):
    descent, best = found
    tangent = Tangent(descent, best.support, best.leading, best.coefficients)
    return list(tangent.proposals(np.random.default_rng(seed), 10, more))


@pytest.mark.parametrize("more", [-1, 0, 1])
def test_sizes_and_order(found, more):
    made = proposals(found, more)
    assert made
    assert [p.rms for p in made] == sorted(p.rms for p in made)
    for p in made:
        assert sum(map(len, p.support)) == len(p.coefficients) == 4 + more
        assert found[1].leading not in p.support[-1]
    assert len({str(p.support) for p in made}) == len(made)


def test_the_prediction_is_the_linear_problems(found):
    descent, best = found
    value, inner, jac = descent.jacobian(best.chosen, best.leading, best.coefficients)
    target = jac @ best.coefficients - (value - descent.target.values) * descent.root_w
    for p in proposals(found)[:5]:
        rows = zip(descent.columns, p.support, inner, strict=True)
        columns = np.concatenate([x[:, s] * row[:, None] for x, s, row in rows], axis=1)
        squares = np.sum((columns @ p.coefficients - target) ** 2)
        # Both are small beside the target: rounding of the normal equations.
        assert np.sqrt(squares) == pytest.approx(p.rms, rel=1e-3, abs=1e-9)


def test_one_seed_gives_one_list(found):
    first, again, other = proposals(found), proposals(found), proposals(found, seed=1)
    assert [p.support for p in first] == [p.support for p in again]
    assert [p.support for p in first] != [p.support for p in other]
