"""The minimum over a box is found and bounded, between nodes too."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecfit.forms import Terms, minimum, smallest_denominator, total_degree


def values(coefficients: np.ndarray, exponents: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.prod(points[:, None, :] ** exponents[None], axis=2) @ coefficients


@settings(deadline=None, max_examples=60)
@given(st.integers(1, 3), st.integers(1, 4), st.integers(0, 10**6))
def test_the_bound_is_below_and_the_value_is_attained(variables: int, degree: int, seed: int):
    rng = np.random.default_rng(seed)
    exponents = total_degree(variables, degree)
    coefficients = rng.normal(size=len(exponents))
    box = [tuple(sorted(rng.uniform(-1.0, 2.0, 2))) for _ in range(variables)]
    found = minimum(coefficients, exponents, box)
    low, high = np.array(box).T
    sample = values(coefficients, exponents, low + (high - low) * rng.uniform(size=(2000, variables)))
    slack = 1e-10 * np.abs(coefficients).sum() * 3.0**degree
    assert found.bound <= sample.min() + slack
    assert found.bound <= found.value + slack
    assert found.value - found.bound <= 1e-8 * max(1.0, abs(found.value)) + slack
    attained = values(coefficients, exponents, np.array([found.place]))[0]
    assert attained == pytest.approx(
        found.value, abs=1e-9 * max(1.0, np.abs(coefficients).sum() * 3.0**degree)
    )
    assert all(a - 1e-12 <= x <= b + 1e-12 for x, (a, b) in zip(found.place, box, strict=True))


def test_a_narrow_dip_between_nodes_is_found():
    # (x - 0.3137)^2 - 1e-6 is positive on any grid that misses 0.3137 by more than 1e-3.
    exponents = np.array([[0], [1], [2]])
    coefficients = np.array([0.3137**2 - 1e-6, -2.0 * 0.3137, 1.0])
    grid = values(coefficients, exponents, np.linspace(0.0, 1.0, 201)[:, None])
    assert grid.min() > 0.0
    found = minimum(coefficients, exponents, [(0.0, 1.0)])
    assert found.value == pytest.approx(-1e-6, rel=1e-3)
    assert found.place[0] == pytest.approx(0.3137, abs=1e-3)


def test_a_denominator_is_judged_by_its_sign_in_the_domain():
    # Q = 1 - 4 x is 1 at the origin but negative, without a zero, on [0.5, 1].
    terms = Terms(np.array([[0]]), np.array([[1]]))
    coefficients = np.array([1.0, -4.0])
    assert smallest_denominator(terms, coefficients, [(0.5, 1.0)]).bound == pytest.approx(1.0)
    assert smallest_denominator(terms, coefficients, [(0.0, 1.0)]).bound < 0.0
