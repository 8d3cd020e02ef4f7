"""Microfacet diffuse: its limits, symmetries and energy."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import MicrofacetDiffuse


def direction(mu, phi=0.0):
    s = np.sqrt(1.0 - mu * mu)
    return jnp.array([s * np.cos(phi), s * np.sin(phi), mu])


@cache
def f(fresnel: str = "schlick"):
    def one(alpha, wo, wi):
        return MicrofacetDiffuse(alpha=alpha, F0=0.04, fresnel=fresnel).f(wo, wi)

    return jax.jit(one)


def test_a_smooth_surface_is_the_lambertian_of_shirley():
    """21 / (20 pi) (1 - F0) (1 - (1 - mu_o)^5) (1 - (1 - mu_i)^5) (Shirley et al. 1997)."""
    mu_o, mu_i = 0.3, 0.7
    expected = 21.0 / (20.0 * np.pi) * 0.96 * (1.0 - (1.0 - mu_o) ** 5) * (1.0 - (1.0 - mu_i) ** 5)
    assert float(f()(0.0, direction(mu_o), direction(mu_i, 2.0))) == pytest.approx(expected, rel=1e-9)
    assert float(f("unit")(0.0, direction(mu_o), direction(mu_i))) == pytest.approx(1 / np.pi, rel=1e-9)


def test_it_is_reciprocal_isotropic_and_black_below():
    there = f()(0.4, direction(0.2, 1.0), direction(0.6, 2.5))
    back = f()(0.4, direction(0.6, -3.0), direction(0.2, -1.5))
    assert float(there) == pytest.approx(float(back), abs=1e-7)
    assert float(f()(0.4, direction(0.2), direction(-0.6))) == 0.0


def test_the_azimuth_does_not_matter_along_the_normal():
    values = [float(f()(0.4, direction(1.0), direction(0.5, phi))) for phi in (0.0, 1.0, 3.0)]
    np.testing.assert_allclose(values, values[0], rtol=1e-12)


@pytest.mark.slow
def test_the_gradient_is_the_difference():
    wo, wi = direction(0.4), direction(0.3, 1.2)
    slope = float(jax.jit(jax.grad(f()))(0.35, wo, wi))
    step = 1e-4
    difference = float(f()(0.35 + step, wo, wi) - f()(0.35 - step, wo, wi)) / (2.0 * step)
    assert slope == pytest.approx(difference, abs=1e-5)


@pytest.mark.slow
def test_energy_is_complete_at_alpha_0_and_lost_between_facets():
    """1 - E of a smooth surface is what Schlick's facet reflects; rough ones lose what bounces twice."""
    mu = [0.1, 0.5, 1.0]
    table = ecfit.tabulate("microfacet-diffuse", {"alpha": [0.0, 0.8], "mu": mu}, tolerance=2e-3)
    assert np.all(table.status == 0)
    np.testing.assert_allclose(table.values[0], 1.0 - (1.0 - np.array(mu)) ** 5, atol=1e-5)
    assert np.all(table.values[1, 1:] < 0.8)
