"""The multiple-bounce factor, against its series and the closed albedos of diffuse models."""

import equinox as eqx
import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.bsdf import Conductor
from ecfit.compensation import kulla_conty_fresnel
from ecfit.errors import EcfitError
from ecfit.quantities import AverageAlbedo, MultipleBounces


@eqx.filter_jit
def factor(model):
    return MultipleBounces().estimate(model, jnp.asarray(1.0), 0)


def test_it_is_the_sum_over_bounces():
    """Bounce by bounce: of what is inside, F is reflected, E_avg of that leaves and the rest goes on."""
    model = Conductor(alpha=0.8, fresnel="schlick", F0=0.6)
    white, reflectance = model.per_bounce()
    average = float(eqx.filter_jit(AverageAlbedo().estimate)(white, jnp.asarray(1.0), 0).value)
    inside, out = 1.0 - average, 0.0  # per unit of light that has bounced once, without its Fresnel factor
    light = float(reflectance) * inside
    for _ in range(200):
        light *= float(reflectance)
        out += light * average
        light *= 1.0 - average
    found = factor(model)
    assert float(found.value) == pytest.approx(out / inside, abs=1e-12)
    assert float(found.value) == pytest.approx(
        float(kulla_conty_fresnel(float(reflectance), average)), abs=1e-14
    )
    assert 0.0 < float(found.error) < 1e-2


@pytest.mark.parametrize(("F0", "F90"), [(0.0, 1.0), (0.3, 0.9), (1.0, 1.0)])
def test_the_mean_reflectance_of_schlick_is_exact(F0, F90):
    reflectance = Conductor(fresnel="schlick", F0=F0, F90=F90).per_bounce()[1]
    assert float(reflectance) == pytest.approx(F0 + (F90 - F0) / 21.0, abs=1e-13)


@pytest.mark.parametrize(("eta", "k"), [(0.2, 3.9), (0.01, 0.5), (3.0, 3.3)])
def test_the_mean_reflectance_of_metals_agrees_with_panels(eta, k, panels):
    model = Conductor(fresnel="exact", eta=eta, k=k)
    x, weight = panels([0.0, 1.0], 30, 20)
    expected = 2.0 * weight @ (np.asarray(model.fresnel_factor()(jnp.asarray(x))) * x)
    assert float(model.per_bounce()[1]) == pytest.approx(expected, abs=1e-11)


def test_a_white_surface_has_the_factor_one_and_a_black_one_none():
    white = Conductor(alpha=0.7, fresnel="schlick", F0=1.0)
    assert float(factor(white).value) == pytest.approx(1.0, abs=1e-12)
    black = ecfit.model("qon", sigma=0.8, rho=0.0)
    assert float(factor(black).value) == 0.0


def test_of_diffuse_facets_it_has_a_closed_form():
    model = ecfit.model("qon", sigma=0.8, rho=0.6)
    average = float(ecfit.model("qon", sigma=0.8).exact_average())
    expected = 0.36 * average / (1.0 - 0.6 * (1.0 - average))
    found = factor(model)
    assert float(found.value) == pytest.approx(expected, abs=float(found.error) + 1e-12)
    assert float(found.error) < 1e-2


def test_the_published_diffuse_factor_is_the_series_at_one_roughness():
    """tau is 1 - E_avg: 0.2843, which the qualitative model has at sigma = 0.99 rad."""
    tau = 0.28430405702379613
    published = ecfit.published("mayaux-2018-diffuse-saturation")
    rho = np.linspace(0.0, 1.0, 11)
    series = rho**2 * (1.0 - tau) / (1.0 - rho * tau)
    np.testing.assert_allclose(np.asarray(published(sigma=0.3, rho=rho)), series, atol=1e-15)
    average = [float(ecfit.model("qon", sigma=s).exact_average()) for s in (0.97, 1.0)]
    assert average[0] > 1.0 - tau > average[1]


def test_the_published_factor_of_metals_is_the_series_at_one_roughness():
    """At alpha = 0.5; at others it is off by five times as much and more."""
    F0 = np.linspace(0.0, 1.0, 21)
    published = np.asarray(ecfit.published("mayaux-2018-saturation")(alpha=0.5, F0=F0))
    rms = {}
    for alpha in (0.25, 0.5, 1.0):
        average = eqx.filter_jit(AverageAlbedo().estimate)(Conductor(alpha=alpha), jnp.asarray(1.0), 0).value
        series = kulla_conty_fresnel(F0 + (1.0 - F0) / 21.0, float(average))
        rms[alpha] = float(np.sqrt(np.mean((published - series) ** 2)))
    assert rms[0.5] < 5e-3
    assert min(rms[0.25], rms[1.0]) > 5.0 * rms[0.5]


def test_a_model_that_does_not_say_what_a_bounce_reflects_is_refused():
    with pytest.raises(EcfitError, match="Dielectric does not say what a bounce reflects"):
        factor(ecfit.model("dielectric"))
