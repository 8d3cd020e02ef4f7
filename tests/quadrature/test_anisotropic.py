"""Anisotropic GGX: the isotropic limit, brute force over directions, and the mean over azimuths."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import AnisotropicConductor
from ecfit.quadrature import Hemisphere

MU = jnp.asarray([0.05, 0.4, 1.0])


def albedo(model: AnisotropicConductor, level: int = 2, mu: jax.Array = MU) -> np.ndarray:
    measure = model.measure()
    return np.asarray(jax.jit(jax.vmap(lambda m: measure.albedo(m, level, "all").value))(mu))


def test_equal_widths_are_the_isotropic_lobe():
    expected = ecfit.directional_albedo(
        ecfit.model("conductor", masking="height-correlated"), mu=MU, alpha=0.5
    )
    np.testing.assert_allclose(albedo(AnisotropicConductor(alpha=0.5, phi=0.3)), expected, atol=1e-8)


@pytest.mark.parametrize(("aspect", "phi"), [(0.3, 1.1), (0.6, 0.0), (0.6, 0.5 * np.pi)])
def test_it_is_the_integral_over_directions(aspect, phi):
    model = AnisotropicConductor(alpha=1.0, aspect=aspect, phi=phi, fresnel="schlick", F0=0.2)
    rule = Hemisphere(model.f, False)
    expected = jax.jit(jax.vmap(lambda m: rule.albedo(m, 3, "all").value))(MU)
    np.testing.assert_allclose(albedo(model), expected, atol=2e-6)


def test_the_mean_over_azimuths_is_that_of_single_ones():
    model = AnisotropicConductor(alpha=0.8, aspect=0.4, azimuth="averaged")
    x, w = np.polynomial.legendre.leggauss(12)
    phi = 0.25 * np.pi * (x + 1.0)
    mu = jnp.asarray([0.3])

    def at(p):
        return AnisotropicConductor(alpha=0.8, aspect=0.4, phi=p).measure().albedo(mu[0], 2, "all").value

    single = np.asarray(jax.jit(jax.vmap(at))(jnp.asarray(phi)))
    assert albedo(model, mu=mu)[0] == pytest.approx(0.5 * w @ single, abs=1e-7)
    assert "phi" not in model.active_parameters()


def test_it_is_reciprocal_and_dark_below():
    model = AnisotropicConductor(alpha=0.7, aspect=0.2)
    wo, wi = jnp.asarray([0.6, 0.0, 0.8]), jnp.asarray([0.1, -0.7, np.sqrt(0.5)])
    assert float(model.f(wo, wi)) == pytest.approx(float(model.f(wi, wo)), rel=1e-12)
    assert float(model.f(wo, -wi)) == 0.0
