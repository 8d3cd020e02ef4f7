"""The isotropic stand-in of an anisotropic surface: exact for equal widths, near the integral otherwise."""

import numpy as np

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import AnisotropicConductor
from ecfit.enterprise import isotropic_equivalent


def test_equal_widths_change_nothing():
    alpha, mu = isotropic_equivalent(0.4, 0.4, 0.7, jnp.asarray([0.0, 0.1, 1.0]))
    np.testing.assert_allclose(alpha, 0.4, rtol=1e-14)
    np.testing.assert_allclose(mu, [0.0, 0.1, 1.0], atol=1e-14)


def test_it_is_near_the_integral_where_the_printed_product_is_far():
    phi = jnp.asarray([0.0, 0.6, 1.5])
    mu = jnp.asarray([0.1, 0.4, 0.9])
    u, v = 0.8, 0.2

    def one(p, m):
        return AnisotropicConductor(alpha=u, aspect=v / u, phi=p).measure().albedo(m, 1, "all").value

    each = jax.vmap(jax.vmap(one, (None, 0)), (0, None))
    truth = jax.jit(each)(phi, mu)
    isotropic = ecfit.model("conductor", masking="height-correlated")
    alpha, cosine = isotropic_equivalent(u, v, phi[:, None], mu)
    ours = ecfit.directional_albedo(isotropic, alpha=alpha, mu=cosine)
    printed = ecfit.directional_albedo(isotropic, alpha=jnp.full((3, 1), u * v), mu=mu)
    assert np.max(np.abs(ours - truth)) < 0.04
    assert np.max(np.abs(printed - truth)) > 0.2
