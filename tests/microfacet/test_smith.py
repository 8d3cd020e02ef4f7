"""Smith masking-shadowing: its bounds, symmetry and limits."""

import numpy as np
import pytest

from ecfit._jax import jnp
from ecfit.microfacet import G1, G2, MASKINGS, NDFS, Lambda, masking_shadowing

VALUES = np.concatenate([[1e-6, 1e-3], np.linspace(0.02, 1.0, 15)])
MU_O, MU_I, ALPHA = (jnp.asarray(v) for v in np.meshgrid(VALUES, VALUES, VALUES, indexing="ij"))

both = pytest.mark.parametrize("name", NDFS)
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
@pytest.mark.parametrize(("mu_o", "mu_i"), [(0.0, 0.5), (0.5, 0.0), (0.0, 0.0), (0.0, 1.0)])
@pytest.mark.parametrize("alpha", [0.0, 1e-3, 1.0])
def test_the_quotient_of_bsdfs_is_finite_at_grazing(name, masking, mu_o, mu_i, alpha):
    arguments = [jnp.asarray(v) for v in (mu_o, mu_i, alpha)]
    value = float(masking_shadowing(NDFS[name], masking, *arguments))
    assert np.isfinite(value)
    assert value >= 0.0
