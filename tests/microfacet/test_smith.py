"""Smith masking-shadowing: its bounds, symmetry and limits."""

import math

import numpy as np
import pytest

from ecfit._jax import jnp
from ecfit.microfacet import G1, G2, MASKINGS, NDFS, Lambda, masking_shadowing
from ecfit.microfacet.smith import _log_beta

VALUES = np.concatenate([[1e-6, 1e-3], np.linspace(0.02, 1.0, 15)])
MU_O, MU_I, ALPHA = (jnp.asarray(v) for v in np.meshgrid(VALUES, VALUES, VALUES, indexing="ij"))

both = pytest.mark.parametrize("name", NDFS)
each_grazing = pytest.mark.parametrize(("mu_o", "mu_i"), [(0.0, 0.5), (0.5, 0.0), (0.0, 0.0), (0.0, 1.0)])
each_masking = pytest.mark.parametrize("masking", MASKINGS)


@both
def test_G1_is_one_over_one_plus_lambda(name):
    ndf = NDFS[name]
    g1 = G1(ndf, MU_O, ALPHA)
    np.testing.assert_allclose(g1, 1.0 / (1.0 + Lambda(ndf, MU_O, ALPHA)), rtol=1e-14)
    assert float(jnp.min(g1)) >= 0.0
    assert float(jnp.max(g1)) <= 1.0 + 1e-15


@both
def test_G1_vanishes_at_grazing_and_is_one_at_the_normal_of_a_smooth_surface(name):
    assert float(G1(NDFS[name], jnp.asarray(0.0), jnp.asarray(0.5))) == 0.0
    assert float(G1(NDFS[name], jnp.asarray(1.0), jnp.asarray(0.0))) == 1.0


@both
@each_masking
def test_G2_is_symmetric_and_no_larger_than_either_masking(name, masking):
    ndf = NDFS[name]
    g2 = np.asarray(G2(ndf, masking, MU_O, MU_I, ALPHA))
    least = np.minimum(G1(ndf, MU_O, ALPHA), G1(ndf, MU_I, ALPHA))
    assert np.all(g2 <= least * (1.0 + 1e-14))
    assert np.all(g2 >= 0.0)
    np.testing.assert_allclose(g2, G2(ndf, masking, MU_I, MU_O, ALPHA), rtol=1e-14)


@both
def test_height_correlation_lets_more_light_through(name):
    ndf = NDFS[name]
    separable = np.asarray(G2(ndf, "separable", MU_O, MU_I, ALPHA))
    correlated = np.asarray(G2(ndf, "height-correlated", MU_O, MU_I, ALPHA))
    assert np.all(correlated >= separable * (1.0 - 1e-14))
    # At mu = 0.02 and alpha = 1 it is several times as much: the forms are not accidentally the same.
    assert correlated[2, 2, -1] > 3.0 * separable[2, 2, -1]


@both
def test_both_forms_agree_with_their_formulas(name):
    ndf = NDFS[name]
    l_o, l_i = Lambda(ndf, MU_O, ALPHA), Lambda(ndf, MU_I, ALPHA)
    np.testing.assert_allclose(
        G2(ndf, "separable", MU_O, MU_I, ALPHA), 1.0 / ((1.0 + l_o) * (1.0 + l_i)), rtol=1e-13
    )
    np.testing.assert_allclose(
        G2(ndf, "height-correlated", MU_O, MU_I, ALPHA), 1.0 / (1.0 + l_o + l_i), rtol=1e-13
    )


@both
@each_masking
@each_grazing
@pytest.mark.parametrize("alpha", [0.0, 1e-3, 1.0])
def test_the_quotient_of_bsdfs_is_finite_at_grazing(name, masking, mu_o, mu_i, alpha):
    arguments = [jnp.asarray(v) for v in (mu_o, mu_i, alpha)]
    value = float(masking_shadowing(NDFS[name], masking, *arguments))
    assert np.isfinite(value)
    assert value >= 0.0


def opposite(name: str, masking: str, mu_o, mu_i, alpha) -> np.ndarray:
    """G2 of directions on opposite sides."""
    arrays = [jnp.asarray(v) for v in (mu_o, mu_i, alpha)]
    quotient = masking_shadowing(NDFS[name], masking, *arrays, opposite=True)
    return np.asarray(quotient * arrays[0] * arrays[1])


BETA = "height-correlated-beta"


@pytest.mark.parametrize("a", [1.0, 1.5, 2.0, 3.5, 10.0])
@pytest.mark.parametrize("b", [1.0, 1.5, 4.0, 20.5])
def test_the_beta_function_is_that_of_the_gamma_function(a, b):
    expected = math.gamma(a) * math.gamma(b) / math.gamma(a + b)
    assert math.exp(float(_log_beta(jnp.asarray(a), jnp.asarray(b)))) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("a", [990.0, 1010.0, 1e6, 1e12])
def test_the_beta_function_keeps_its_digits_for_large_arguments(a):
    """B(a, 2) = 1 / (a (a + 1)): next to a = 1000 one formula takes over from the other."""
    found = float(_log_beta(jnp.asarray(a), jnp.asarray(2.0)))
    assert found == pytest.approx(-math.log(a * (a + 1.0)), abs=1e-9)


@both
def test_height_correlation_on_opposite_sides_is_a_beta_function(name):
    """B(1 + Lambda_o, 1 + Lambda_i) (Heitz et al. 2016): by lgamma here."""
    values = np.linspace(0.1, 1.0, 7)
    mu_o, mu_i, alpha = np.meshgrid(values, values, values)
    l_o, l_i = (
        np.asarray(Lambda(NDFS[name], jnp.asarray(m), jnp.asarray(alpha))).ravel() for m in (mu_o, mu_i)
    )
    expected = [
        math.exp(math.lgamma(1.0 + a) + math.lgamma(1.0 + b) - math.lgamma(2.0 + a + b))
        for a, b in zip(l_o, l_i, strict=True)
    ]
    np.testing.assert_allclose(opposite(name, BETA, mu_o, mu_i, alpha).ravel(), expected, rtol=1e-12)


@both
def test_the_beta_form_is_symmetric_and_lets_less_light_through(name):
    """Sides that are opposite are seldom visible together: B(1 + a, 1 + b) <= 1 / (1 + a + b)."""
    g2 = opposite(name, BETA, MU_O, MU_I, ALPHA)
    np.testing.assert_allclose(g2, opposite(name, BETA, MU_I, MU_O, ALPHA), rtol=1e-9)
    assert np.all(g2 >= 0.0)
    assert np.all(g2 <= opposite(name, "height-correlated", MU_O, MU_I, ALPHA) * (1.0 + 1e-9))
    # At mu = 0.1 and alpha = 1 much less: the forms are not accidentally the same.
    ends = (0.1, 0.1, 1.0)
    assert opposite(name, BETA, *ends) < 0.2 * opposite(name, "height-correlated", *ends)


@both
def test_the_beta_form_of_reflection_is_the_height_correlated_one(name):
    arguments = NDFS[name], MU_O, MU_I, ALPHA
    np.testing.assert_array_equal(
        masking_shadowing(arguments[0], BETA, *arguments[1:]),
        masking_shadowing(arguments[0], "height-correlated", *arguments[1:]),
    )


@both
def test_the_beta_form_with_light_at_the_normal_of_a_rough_surface_is_its_masking(name):
    """B(1 + a, 1) = 1 / (1 + a): where one direction sees no masking the other's remains."""
    mu = np.array([0.05, 0.3, 0.9])
    found = opposite(name, BETA, mu, np.ones(3), np.full(3, 0.5))
    np.testing.assert_allclose(found, G1(NDFS[name], jnp.asarray(mu), jnp.asarray(0.5)), rtol=1e-9)


@both
@each_grazing
@pytest.mark.parametrize("alpha", [1e-3, 1.0])
def test_the_beta_quotient_is_finite_at_grazing(name, mu_o, mu_i, alpha):
    arrays = [jnp.asarray(v) for v in (mu_o, mu_i, alpha)]
    beta, plain = (
        float(masking_shadowing(NDFS[name], masking, *arrays, opposite=True))
        for masking in (BETA, "height-correlated")
    )
    assert 0.0 <= beta <= plain * (1.0 + 1e-8)


@both
@pytest.mark.parametrize("mu_o", [1e-4, 1e-7])
def test_the_beta_form_falls_towards_grazing_with_a_power_of_lambda(name, mu_o):
    """B(1 + a, 1 + b) ~ Gamma(1 + b) a^-(1 + b) for a -> infinity, by Stirling's formula."""
    a, b = (float(Lambda(NDFS[name], jnp.asarray(m), jnp.asarray(1.0))) for m in (mu_o, 0.3))
    expected = math.gamma(1.0 + b) * a ** -(1.0 + b)
    # The next term is of order 1 / a, and the logarithm of 1e-14 keeps ten digits.
    assert opposite(name, BETA, mu_o, 0.3, 1.0) == pytest.approx(expected, rel=20.0 * mu_o + 1e-8)
