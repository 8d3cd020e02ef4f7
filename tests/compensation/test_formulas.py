"""The formulas of compensation, by hand, for numbers and arrays alike."""

import math

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.compensation import kulla_conty_fresnel, kulla_conty_lobe, turquin_factor


def test_a_white_surface_is_scaled_by_one_over_its_albedo():
    assert turquin_factor(0.8) == pytest.approx(1.25, rel=1e-15)
    assert turquin_factor(1.0, 0.3) == 1.0
    # 1 + 0.5 x 0.2 / 0.8
    assert turquin_factor(0.8, 0.5) == pytest.approx(1.125, rel=1e-15)


def test_the_diffuse_lobe_returns_what_is_lost():
    """Constant E = 0.6: 0.4 x 0.4 / (pi 0.4), whose integral over the cosine is 0.4."""
    assert kulla_conty_lobe(0.6, 0.6, 0.6) * math.pi == pytest.approx(0.4, rel=1e-15)
    assert kulla_conty_lobe(1.0, 0.6, 0.6) == 0.0


def test_the_tint_is_the_sum_over_all_later_bounces():
    """F_avg E_avg of each bounce leaves: sum over k of F^k+1 (1 - E)^k E, less the first bounce's own F."""
    F, E = 0.7, 0.6
    bounces = sum(F ** (k + 1) * (1.0 - E) ** k * E for k in range(1, 200)) / (1.0 - E)
    assert kulla_conty_fresnel(F, E) == pytest.approx(bounces, rel=1e-14)


@pytest.mark.parametrize(
    ("formula", "arguments"),
    [
        (turquin_factor, (0.7, 0.5)),
        (kulla_conty_lobe, (0.7, 0.6, 0.8, 0.9)),
        (kulla_conty_fresnel, (0.7, 0.6)),
    ],
)
def test_arrays_of_numpy_and_jax_are_treated_alike(formula, arguments):
    expected = formula(*arguments)
    plain = formula(*(np.full(3, a) for a in arguments))
    traced = jax.jit(formula)(*(jnp.full(3, a) for a in arguments))
    assert isinstance(plain, np.ndarray)
    np.testing.assert_allclose(plain, expected, rtol=1e-15)
    np.testing.assert_allclose(traced, expected, rtol=1e-14)
