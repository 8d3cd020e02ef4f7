"""The Lambertian: f and the albedo that it states."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.bsdf import Lambertian

UP, DOWN = jnp.array([0.0, 0.0, 1.0]), jnp.array([0.6, 0.0, -0.8])


def test_f_is_rho_over_pi_above_and_nothing_below():
    model = ecfit.model("lambertian", rho=0.5)
    assert float(model.f(UP, UP)) == pytest.approx(0.5 / np.pi, rel=1e-15)
    assert float(model.f(UP, DOWN)) == 0.0


def test_the_stated_albedo_is_the_integral():
    model = Lambertian(rho=jnp.asarray(0.5))
    mu = jnp.asarray([0.0, 0.3, 1.0])
    np.testing.assert_array_equal(model.exact_albedo(mu), [0.5, 0.5, 0.5])
    np.testing.assert_allclose(ecfit.directional_albedo(model, mu=mu, level=2), 0.5, rtol=1e-12)
