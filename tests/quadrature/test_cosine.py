"""Averages over the cosine of the view: exactness, kinks, and errors that are handed on."""

import numpy as np
import pytest

from ecfit._jax import jnp
from ecfit.quadrature import CosineRule, Estimate


def known(value, error=0.0):
    return Estimate(value, jnp.full_like(value, error))


def test_an_average_has_the_error_of_its_values():
    found = CosineRule.between(8).average(lambda mu: known(mu**2, 1e-3))
    assert float(found.value) == pytest.approx(0.5, abs=1e-12)
    assert 1e-3 <= float(found.error) < 2e-3


def test_a_kink_is_integrated_exactly_only_where_it_is_known():
    """2 x integral of |mu - 0.3| mu = 0.3^3 / 3 + 2 / 3 - 0.3 + 0.3^3 / 3."""
    exact = 2.0 * 0.3**3 / 3.0 + 2.0 / 3.0 - 0.3
    told, untold = (
        float(CosineRule.between(12, kinks).average(lambda mu: known(jnp.abs(mu - 0.3))).value)
        for kinks in (jnp.asarray([0.3]), None)
    )
    assert told == pytest.approx(exact, abs=1e-13)
    assert abs(untold - exact) > 1e-5


def test_any_weight_and_what_is_lost():
    rule = CosineRule.between(10)
    found = rule.integral(lambda mu: known(0.25 * jnp.ones_like(mu)), rule.mu**3, lambda e: 1.0 - e)
    np.testing.assert_allclose(found.value, 0.75 / 4.0, atol=1e-14)
