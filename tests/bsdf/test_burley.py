"""Burley's diffuse model: its polynomial albedo against quadrature, and f as printed."""

import math

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp


def test_the_stated_albedo_is_the_integral():
    r, mu = jnp.array([[0.0], [0.4], [1.0]]), jnp.array([0.0, 0.1, 0.6, 1.0])
    model = ecfit.model("burley", rho=0.7)
    stated = model.with_parameters({"r": r}).exact_albedo(mu)
    np.testing.assert_allclose(ecfit.directional_albedo(model, r=r, mu=mu), stated, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_check_bsdf():
    found = ecfit.check_bsdf("burley", samples=100)
    assert found, str(found)


def test_f_by_its_half_vector():
    wo = np.array([math.sin(1.1), 0.0, math.cos(1.1)])
    wi = np.array([math.sin(0.6) * math.cos(2.0), math.sin(0.6) * math.sin(2.0), math.cos(0.6)])
    h = (wo + wi) / np.linalg.norm(wo + wi)
    f90 = 0.5 + 2.0 * 0.8 * float(wi @ h) ** 2
    expected = (1.0 + (f90 - 1.0) * (1.0 - wo[2]) ** 5) * (1.0 + (f90 - 1.0) * (1.0 - wi[2]) ** 5) / math.pi
    assert float(ecfit.model("burley", r=0.8).f(jnp.asarray(wo), jnp.asarray(wi))) == pytest.approx(
        expected, rel=1e-13
    )


def test_it_makes_energy_at_grazing_angles_of_rough_surfaces_and_says_so():
    model = ecfit.model("burley", r=1.0)
    assert float(model.exact_albedo(jnp.asarray(0.0))) > 1.5
    assert not model.conserving
