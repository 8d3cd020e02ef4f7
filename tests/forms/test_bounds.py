"""Bounds hold at every step of the subdivision, not only where it has converged."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.forms import minimum, total_degree


@pytest.mark.parametrize("splits", [0, 1, 5])
@given(variables=st.integers(1, 3), degree=st.integers(1, 4), seed=st.integers(0, 10**6))
def test_an_early_stop_leaves_bounds_on_both_sides(splits, variables, degree, seed):
    rng = np.random.default_rng(seed)
    exponents = total_degree(variables, degree)
    coefficients = rng.normal(size=len(exponents))
    found = minimum(coefficients, exponents, [(0.0, 1.0)] * variables, splits=splits)
    points = rng.uniform(size=(500, variables))
    values = np.prod(points[:, None, :] ** exponents, axis=2) @ coefficients
    assert found.bound <= values.min() + 1e-12
    assert found.bound <= found.value
    attained = np.prod(np.array(found.place) ** exponents, axis=1) @ coefficients
    assert attained == pytest.approx(found.value, abs=1e-12)


def test_subdivision_closes_the_gap():
    """A bump of 4 x (1 - x) turned over: Bernstein coefficients alone bound its minimum of -1 by -2."""
    exponents, coefficients = np.array([[1], [2]]), np.array([-4.0, 4.0])
    gaps = [
        found.value - found.bound
        for found in (minimum(coefficients, exponents, [(0.0, 1.0)], splits=s) for s in (0, 1, 4000))
    ]
    assert gaps[0] == pytest.approx(2.0)
    assert gaps[-1] <= 1e-9


def test_degree_zero_is_its_own_minimum():
    found = minimum(np.array([3.0]), np.array([[0, 0]]), [(0.0, 1.0), (-1.0, 1.0)])
    assert (found.value, found.bound) == (3.0, 3.0)
