"""Horner's scheme on sparse polynomials: the same value, fewer operations."""

import numpy as np
import pytest

from ecfit.expressions import cost, value
from ecfit.forms.features import monomial, plain
from ecfit.forms.nested import nested

FEATURES = ("alpha", "mu", "g")
NODES = {f: plain(f) for f in FEATURES}
POINTS = {"alpha": np.array([0.0, 0.1, 0.37, 1.0]), "mu": np.array([1.0, 0.0, 0.61, 0.2])}


def plainly(exponents: np.ndarray, coefficients: np.ndarray):
    terms = [monomial(dict(zip(FEATURES, map(float, row), strict=True)), NODES) for row in exponents]
    total = terms[0] * float(coefficients[0])
    for c, term in zip(coefficients[1:], terms[1:], strict=True):
        total = total + term * float(c)
    return total


@pytest.mark.parametrize("count", [1, 2, 7, 20])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_value_is_that_of_the_sum_and_costs_no_more(count: int, seed: int):
    rng = np.random.default_rng(seed)
    exponents = np.unique(0.5 * rng.integers(0, 6, (count, 3)), axis=0)
    coefficients = rng.normal(size=len(exponents))
    found, sum_ = nested(exponents, coefficients, FEATURES, NODES), plainly(exponents, coefficients)
    np.testing.assert_allclose(value(found, POINTS), value(sum_, POINTS), rtol=1e-12, atol=1e-13)
    assert cost(found).total <= cost(sum_).total
    if count == 20:
        assert cost(found).total < 0.9 * cost(sum_).total


def test_the_first_of_two_features_that_are_shared_alike_is_taken_out():
    exponents = np.array([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0]])
    found = nested(exponents, np.array([2.0, 3.0]), FEATURES, NODES)
    assert repr(found) == "mul(alpha, mul(mu, add(2.0, mul(alpha, 3.0))))"


def test_a_constant_alone_is_itself():
    found = nested(np.zeros((1, 3)), np.array([0.25]), FEATURES, NODES)
    assert found.op == "const"
    assert found.value == 0.25
