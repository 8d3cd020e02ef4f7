"""Oren-Nayar models: closed albedos against quadrature, and the source's own formulas."""

import math

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf.oren_nayar import FUJII_LOSS, fujii_deficit, fujii_g, qualitative_g
from ecfit.compensation.formulas import kulla_conty_fresnel, kulla_conty_lobe
from ecfit.quantities import AverageAlbedo

MU = np.array([0.0, 1e-6, 1e-3, 0.05, 0.4, 0.8, 0.999, 1.0])
THETA = np.linspace(0.0, 1.57, 50)

POINTS = {
    "qon": {"sigma": np.array([0.0, 0.1, 0.5, 0.5 * np.pi]), "rho": np.array([1.0, 0.3, 0.3, 1.0])},
    "fon": {"diffuse_roughness": np.array([0.0, 0.01, 0.5, 1.0]), "rho": np.array([1.0, 0.3, 0.3, 1.0])},
    "eon": {"diffuse_roughness": np.array([0.0, 0.01, 0.5, 1.0]), "rho": np.array([1.0, 0.3, 0.3, 1.0])},
}


@pytest.mark.parametrize("name", list(POINTS))
def test_the_stated_albedo_is_the_integral(name):
    points = {k: v[:, None] for k, v in POINTS[name].items()}
    found = ecfit.directional_albedo(name, mu=MU, **points)
    stated = ecfit.model(name).with_parameters(points).exact_albedo(jnp.asarray(MU))
    np.testing.assert_allclose(found, stated, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", list(POINTS))
def test_the_stated_average_is_the_integral(name):
    def average(point):
        model = ecfit.model(name).with_parameters(point)
        return AverageAlbedo().estimate(model, jnp.asarray(0.0), 2), model.exact_average()

    found, stated = jax.jit(jax.vmap(average))({k: jnp.asarray(v) for k, v in POINTS[name].items()})
    np.testing.assert_allclose(found.value, stated, rtol=0.0, atol=1e-9)
    assert np.all(np.abs(found.value - stated) <= found.error + 1e-13)


def test_tables_reach_1e_9():
    axes = {"diffuse_roughness": np.array([0.0, 0.5, 1.0]), "mu": MU}
    table = ecfit.tabulate("eon", axes, tolerance=1e-9)
    assert np.all(table.status == 0)
    np.testing.assert_allclose(table.values, 1.0, rtol=0.0, atol=1e-9)  # the white furnace


def test_the_albedo_is_the_average_of_eon_over_mu_by_other_means():
    from scipy.integrate import quad

    model = ecfit.model("eon", diffuse_roughness=0.7, rho=0.6)
    found, _ = quad(
        lambda m: 2.0 * m * float(np.asarray(model.exact_albedo(jnp.asarray(m)))), 0.0, 1.0, epsabs=1e-12
    )
    assert float(np.asarray(model.exact_average())) == pytest.approx(found, abs=1e-11)


def test_g_is_the_printed_formula():
    s, c = np.sin(THETA), np.cos(THETA)
    g = s * (THETA - s * c) + 2.0 / 3.0 * np.tan(THETA) * (1.0 - s**3)  # eq. 8
    np.testing.assert_allclose(qualitative_g(jnp.cos(THETA)), g, atol=1e-12)
    np.testing.assert_allclose(fujii_g(jnp.cos(THETA)), g - 2.0 / 3.0 * s, atol=1e-12)
    assert float(qualitative_g(jnp.asarray(0.0))) == pytest.approx(math.pi / 2.0, abs=1e-15)


def test_the_deficit_keeps_its_digits_at_grazing_angles():
    # Its series is mu + (pi - 4/3) mu^2 / 4 + ...: a difference of near equals would leave no digit at 1e-15.
    mu = np.array([1e-15, 1e-12, 1e-6])
    np.testing.assert_allclose(fujii_deficit(jnp.asarray(mu)), mu, rtol=1e-6)
    assert float(fujii_deficit(jnp.asarray(0.0))) == 0.0
    assert float(fujii_deficit(jnp.asarray(1.0))) == pytest.approx(math.pi * FUJII_LOSS, rel=1e-15)


@pytest.mark.parametrize("function", [fujii_deficit, fujii_g, qualitative_g])
def test_slopes_are_finite_everywhere(function):
    assert np.all(np.isfinite(jax.vmap(jax.grad(function))(jnp.asarray(MU))))


@pytest.mark.parametrize("name", ["qon", pytest.param("fon", marks=pytest.mark.slow), "eon"])
def test_check_bsdf(name):
    found = ecfit.check_bsdf(name, samples=100)
    assert found, str(found)


def direction(theta, phi):
    return jnp.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


@pytest.mark.parametrize("phi", [0.4, 2.0])
def test_f_is_the_printed_formula_in_angles(phi):
    o, i = 1.1, 0.6
    tangent = math.sin(o) * math.tan(i)  # sin of the larger angle times tan of the smaller (eq. 2)
    qon = ecfit.model("qon", sigma=0.8, rho=0.7)
    a, b = 1.0 - 0.5 * 0.64 / (0.64 + 0.33), 0.45 * 0.64 / (0.64 + 0.09)
    expected = 0.7 / math.pi * (a + b * max(math.cos(phi), 0.0) * tangent)
    assert float(qon.f(direction(o, 0.0), direction(i, phi))) == pytest.approx(expected, rel=1e-14)
    fon = ecfit.model("fon", diffuse_roughness=0.8, rho=0.7)
    a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * math.pi)) * 0.8)
    shape = math.cos(phi) * (tangent if math.cos(phi) > 0.0 else math.sin(o) * math.sin(i))
    expected = 0.7 / math.pi * a * (1.0 + 0.8 * shape)
    assert float(fon.f(direction(o, 0.0), direction(i, phi))) == pytest.approx(expected, rel=1e-14)


def test_qon_makes_energy_at_grazing_angles_and_says_so():
    # Not of the roughest surfaces, which lose a fifth there.
    model = ecfit.model("qon", sigma=0.2)
    assert float(np.asarray(model.exact_albedo(jnp.asarray(0.0)))) > 1.01
    assert float(np.asarray(ecfit.model("qon", sigma=0.5 * math.pi).exact_albedo(jnp.asarray(0.0)))) < 0.8
    assert not model.conserving


@pytest.mark.parametrize("rho", [0.0, 0.3, 1.0])
def test_eon_at_no_roughness_is_lambert(rho):
    model = ecfit.model("eon", diffuse_roughness=0.0, rho=rho)
    assert float(model.f(direction(1.1, 0.0), direction(0.6, 2.0))) == pytest.approx(rho / math.pi, abs=1e-16)


def test_eon_is_fujii_with_the_lobe_of_kulla_and_conty():
    r, rho = 0.8, 0.6
    fon = ecfit.model("fon", diffuse_roughness=r)
    average = float(np.asarray(fon.exact_average()))
    albedo = fon.exact_albedo(jnp.cos(jnp.array([1.1, 0.6])))
    share = kulla_conty_fresnel(rho, average)
    lobe = kulla_conty_lobe(float(albedo[0]), float(albedo[1]), average, share)
    wo, wi = direction(1.1, 0.0), direction(0.6, 2.0)
    expected = rho * float(fon.f(wo, wi)) + lobe
    found = float(ecfit.model("eon", diffuse_roughness=r, rho=rho).f(wo, wi))
    assert found == pytest.approx(expected, rel=1e-13)


def test_without_the_lobe_a_fifth_is_lost():
    fon, eon = (ecfit.model(n, diffuse_roughness=1.0) for n in ("fon", "eon"))
    assert float(np.asarray(fon.exact_albedo(jnp.asarray(1.0)))) == pytest.approx(
        1.0 / (1.0 + FUJII_LOSS), rel=1e-15
    )
    assert float(np.asarray(eon.exact_albedo(jnp.asarray(1.0)))) == pytest.approx(1.0, abs=1e-15)


def test_oren_nayar_is_another_name_of_qon():
    assert type(ecfit.model("oren-nayar")) is type(ecfit.model("qon"))
    assert ecfit.tabulate("oren-nayar", {"mu": 2}, tolerance=1e-6).contract.model == "qon"
