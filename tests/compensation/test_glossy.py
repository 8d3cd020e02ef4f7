"""The glossy layer: its compensated albedo, its limits, and the white base under it."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.compensation.furnace import furnace_of
from ecfit.compensation.glossy import Glossy
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.forms import Terms
from ecfit.quadrature import Hemisphere

AXES = {"alpha": [0.2, 0.7], "F0": [0.0, 0.04, 0.5, 1.0], "mu": [0.1, 0.5, 1.0]}


@cache
def table(**options) -> ecfit.Table:
    return ecfit.tabulate(ecfit.model("glossy", **options), AXES, tolerance=1e-7)


def test_the_layer_is_the_lobe_with_fresnel_over_the_lobe_without():
    """E_spec = E_F / E_ss; E_F is the reflected lobe of a dielectric."""
    ior, mu = 1.5, jnp.asarray(AXES["mu"])
    layer = ecfit.directional_albedo("glossy", mu=mu, alpha=0.7, ior=ior)
    part = ecfit.directional_albedo("thin-dielectric", mu=mu, alpha=0.7, ior=ior, lobe="reflection")
    white = ecfit.directional_albedo("conductor", mu=mu, alpha=0.7)
    np.testing.assert_allclose(layer, part / white, rtol=1e-12)


def test_no_interface_reflects_nothing_and_an_opaque_one_everything():
    found = table()
    np.testing.assert_allclose(found.values[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(found.values[:, -1], 1.0, atol=1e-7)
    assert np.all(np.diff(found.values, axis=1) > 0.0)


def test_a_rough_layer_reflects_about_F0_at_the_normal():
    """For small alpha F is that of the mirror direction."""
    found = ecfit.directional_albedo("glossy", mu=1.0, alpha=1e-4, F0=0.2)
    assert float(found) == pytest.approx(0.2, abs=1e-6)


def test_over_a_white_base_all_energy_comes_back():
    found = table(base="diffuse", rho=1.0)
    np.testing.assert_allclose(found.values, 1.0, atol=1e-12)


def test_over_a_grey_base_the_rest_is_scaled():
    np.testing.assert_allclose(
        table(base="diffuse", rho=0.3).values, table().values + 0.3 * (1.0 - table().values), atol=2e-7
    )


def constant(value: float, name: str) -> ecfit.Approximation:
    terms = Terms(np.zeros((1, 1), dtype=int), np.zeros((0, 1), dtype=int))
    return ecfit.Approximation.quotient(
        name, "polynomial", "0", ("mu",), terms, np.array([value]), ((0.0, 1.0),), Contract("glossy")
    )


def test_an_approximated_layer_leaves_what_it_misses():
    """E_spec + 1 - E_approximated - 1."""
    found = furnace_of(Glossy(), constant(0.4, "layer"), AXES)
    np.testing.assert_allclose(found.deviation, table().values - 0.4, atol=1e-6)


def test_an_approximated_single_scattering_albedo_scales_the_layer():
    """E_F / E_approximated."""
    model = Glossy(single=constant(0.8, "single"))
    found = ecfit.tabulate(model, AXES, tolerance=1e-7)
    white = ecfit.tabulate("conductor", {k: v for k, v in AXES.items() if k != "F0"}, tolerance=1e-7).values
    np.testing.assert_allclose(found.values, table().values * white[:, None] / 0.8, atol=1e-6)


def test_a_glossy_layer_is_compensated_by_scaling():
    with pytest.raises(EcfitError, match="must be 'turquin'"):
        furnace_of(Glossy(), None, AXES, method="kulla-conty")


@pytest.mark.parametrize("base", ["none", "diffuse"])
def test_f_integrates_to_the_measure(base):
    model = Glossy(base=base, rho=0.5, alpha=0.7)
    mu = jnp.asarray([0.3, 0.9])
    # The albedos in f depend on wo alone: approximations keep the compilation short.
    model = Glossy(base=base, rho=0.5, alpha=0.7, single=constant(0.8, "s"), layer=constant(0.3, "l"))
    by_f = jax.jit(jax.vmap(lambda m: Hemisphere(model.f, False).albedo(m, 3, "all").value))(mu)
    measured = jax.jit(jax.vmap(lambda m: model.measure().albedo(m, 2, "all").value))(mu)
    np.testing.assert_allclose(by_f, measured, atol=1e-6)


def test_f_divides_by_the_exact_albedo_where_nothing_is_given():
    wo, wi = jnp.asarray([0.6, 0.0, 0.8]), jnp.asarray([0.0, 0.8, 0.6])
    thin = ecfit.model("thin-dielectric", alpha=0.7)
    white = ecfit.directional_albedo("conductor", mu=0.8, alpha=0.7)
    expected = float(thin.f(wo, wi)) / float(white)
    assert float(Glossy(alpha=0.7).f(wo, wi)) == pytest.approx(expected, rel=1e-12)


def test_nothing_is_transmitted():
    assert float(ecfit.directional_albedo("glossy", mu=0.5, lobe="transmission", level=0)) == 0.0
    assert (
        float(
            Glossy(base="diffuse", single=constant(1.0, "s"), layer=constant(0.0, "l")).f(
                jnp.asarray([0.0, 0.0, 1.0]), jnp.asarray([0.6, 0.0, -0.8])
            )
        )
        == 0.0
    )


def test_parameters_matter_where_their_options_say():
    assert Glossy().active_parameters() == ("alpha", "ior")
    assert Glossy(fresnel="schlick", base="diffuse").active_parameters() == ("alpha", "ior", "F90", "rho")


@pytest.mark.slow
@pytest.mark.parametrize("base", ["none", "diffuse"])
def test_the_model_keeps_its_promises(base):
    found = ecfit.check_bsdf(Glossy(base=base), samples=50)
    assert found, str(found)
