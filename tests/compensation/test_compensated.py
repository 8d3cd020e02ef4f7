"""Compensated models: nothing is lost in the furnace, and what an approximation misses is told exactly."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import Conductor, Dielectric, Lambertian
from ecfit.compensation import KullaConty, Turquin, compensate, furnace, kulla_conty_fresnel
from ecfit.compensation.furnace import furnace_of
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.forms import Terms
from ecfit.quadrature import Hemisphere

ALPHA, MU = [0.2, 0.7], [0.1, 0.5, 1.0]
AXES = {"alpha": ALPHA, "mu": MU}
ROUGH = jnp.asarray(ALPHA)[:, None]


def linear(names: tuple[str, ...], coefficients: list[float], name: str = "linear") -> ecfit.Approximation:
    """A polynomial of degree 1 in the named coordinates."""
    exponents = np.vstack([np.zeros((1, len(names)), dtype=int), np.eye(len(names), dtype=int)])
    terms = Terms(exponents, np.zeros((0, len(names)), dtype=int))
    domain = ((0.0, 1.0),) * len(names)
    return ecfit.Approximation.quotient(
        name, "polynomial", "1", names, terms, np.array(coefficients), domain, Contract("conductor")
    )


# Near the albedo of a conductor, and not it: 1 - 0.5 r + 0.1 mu.
ROUGHLY = linear(("r", "mu"), [0.9, -0.4, 0.1])


def roughly() -> np.ndarray:
    return np.asarray(ROUGHLY(alpha=ROUGH, mu=jnp.asarray(MU)))


@cache
def albedo(name: str = "conductor", **settings) -> np.ndarray:
    return ecfit.tabulate(ecfit.model(name, **settings), AXES, tolerance=1e-7).values


def test_scaling_by_the_exact_albedo_keeps_all_energy():
    found = furnace(compensate("conductor"), AXES)
    assert found.max <= 1e-6
    assert found.table.contract.options["compensation"] == "Turquin"
    assert found.table.contract.options["albedo"] == "exact"


@pytest.mark.slow
@pytest.mark.parametrize("side", ["entering", "leaving"])
def test_a_dielectric_is_compensated_on_both_lobes(side):
    found = furnace(compensate(ecfit.model("dielectric", side=side)), AXES)
    assert found.max <= 1e-6


def test_an_approximation_leaves_what_it_misses():
    """The furnace shows E / E_approximated - 1, to the digits of the integral."""
    found = furnace(compensate("conductor", ROUGHLY), AXES)
    np.testing.assert_allclose(found.deviation, albedo() / roughly() - 1.0, atol=1e-6)
    assert found.max > 0.02
    assert found.table.contract.options["albedo"] == "linear"


def test_with_a_reflectance_below_one_less_is_put_back():
    """1 + F0 (1 - E) / E times E: E + F0 (1 - E)."""
    model = compensate("conductor", F0=0.3)
    found = ecfit.tabulate(model, AXES, tolerance=1e-6)
    np.testing.assert_allclose(found.values, albedo() + 0.3 * (1.0 - albedo()), atol=1e-6)


def test_the_scaled_model_is_the_base_times_a_factor_of_wo():
    base = Conductor(alpha=0.7)
    model = compensate(base, ROUGHLY, F0=0.5)
    wo, wi = jnp.asarray([0.6, 0.0, 0.8]), jnp.asarray([0.0, 0.8, 0.6])
    E = float(ROUGHLY(alpha=0.7, mu=0.8))
    assert float(model.f(wo, wi)) == pytest.approx(
        float(base.f(wo, wi)) * (1.0 + 0.5 * (1.0 - E) / E), rel=1e-13
    )
    assert not model.reciprocal


@pytest.mark.slow
def test_the_kulla_conty_lobe_of_exact_albedos_keeps_all_energy():
    found = furnace(compensate("conductor", method="kulla-conty"), AXES)
    # 48 nodes in sqrt(mu) carry the average.
    assert found.max <= 1e-5


def test_the_kulla_conty_lobe_of_an_approximation_leaves_what_it_misses():
    """E + (1 - E~(mu)) (1 - <E~>) / (1 - E~_avg) with its own exact average: E - E~ is left."""
    found = furnace(compensate("conductor", ROUGHLY, method="kulla-conty"), AXES)
    np.testing.assert_allclose(found.deviation, albedo() - roughly(), atol=1e-6)


def test_a_wrong_average_of_the_kulla_conty_lobe_shows():
    """(1 - <E~>) / (1 - E~_avg): an average given by a second approximation scales the lobe."""
    average = linear(("r",), [0.8, -0.3], "average")
    found = furnace(compensate("conductor", ROUGHLY, "kulla-conty", average=average), AXES)
    r = np.sqrt(np.asarray(ALPHA))[:, None]
    true = 0.9 - 0.4 * r + 0.1 * 2.0 / 3.0  # 2 x integral of E~ mu dmu
    share = (1.0 - true) / (1.0 - (0.8 - 0.3 * r))
    np.testing.assert_allclose(found.table.values, albedo() + (1.0 - roughly()) * share, atol=1e-6)


@pytest.mark.parametrize("method", ["turquin", "kulla-conty"])
def test_f_integrates_to_the_measure(method):
    """The measure adds what is put back in closed form; f puts it back direction by direction."""
    # An approximated albedo: the exact one of every direction would be a second integral within the first.
    model = compensate(Conductor(alpha=0.7), ROUGHLY, method)
    mu = jnp.asarray([0.3, 0.9])
    by_f = jax.jit(jax.vmap(lambda m: Hemisphere(model.f, False).albedo(m, 3, "all").value))(mu)
    measured = jax.jit(jax.vmap(lambda m: model.measure().albedo(m, 2, "all").value))(mu)
    np.testing.assert_allclose(by_f, measured, atol=1e-6)


def test_the_kulla_conty_lobe_is_reciprocal():
    model = compensate(Conductor(alpha=0.7), ROUGHLY, "kulla-conty")
    wo, wi = jnp.asarray([0.6, 0.0, 0.8]), jnp.asarray([0.0, 0.96, 0.28])
    assert float(model.f(wo, wi)) == pytest.approx(float(model.f(wi, wo)), rel=1e-13)


def test_a_colour_is_lost_at_every_bounce():
    """F_ms scales the lobe: with Kulla & Conty's of F_avg = 1 it is 1."""
    assert kulla_conty_fresnel(1.0, 0.6) == pytest.approx(1.0)
    assert kulla_conty_fresnel(0.0, 0.6) == 0.0
    dark = furnace(compensate("conductor", ROUGHLY, "kulla-conty", F_ms=0.25), AXES)
    np.testing.assert_allclose(dark.table.values, albedo() + 0.25 * (1.0 - roughly()), atol=1e-6)


def test_a_model_that_loses_nothing_is_left_alone():
    for method in ("turquin", "kulla-conty"):
        found = furnace(compensate(Lambertian(rho=1.0), linear(("mu",), [1.0, 0.0]), method), {"mu": MU})
        assert found.max <= 1e-6


def test_a_compensated_model_has_the_settings_of_its_base():
    base = Dielectric(side="leaving", ior=2.0)
    model = compensate(base)
    assert model.parameter_ranges() == base.parameter_ranges()
    assert model.active_parameters() == base.active_parameters()
    assert model.fresnel_parameters == base.fresnel_parameters
    assert model.transmissive
    assert float(model.relative_ior()) == 0.5
    np.testing.assert_array_equal(model.albedo_kinks(), base.albedo_kinks())
    changed = model.with_parameters({"ior": 3.0})
    assert isinstance(changed, Turquin)
    assert float(changed.parameter_value("ior")) == 3.0


@pytest.mark.parametrize(
    ("arguments", "settings", "message"),
    [
        (("dielectric", None, "kulla-conty"), {}, "this model transmits"),
        (("conductor", None, "turqin"), {}, "unknown compensation 'turqin'.*did you mean 'turquin'"),
        (("conductor", linear(("F0", "mu"), [1.0, 0.0, 0.0])), {}, "no parameter 'F0'"),
        (("lambertian", linear(("r", "mu"), [1.0, 0.0, 0.0])), {}, "no parameter 'r'"),
        (("conductor",), {"F90": 1.0}, "does not take F90"),
        (("conductor",), {"transport": "power"}, "unknown transport"),
        (("conductor", None, "kulla-conty"), {"average": linear(("x",), [1.0, 0.0])}, "no parameter 'x'"),
        (("conductor", linear(("x",), [1.0, 0.0]), "kulla-conty"), {}, "no parameter 'x'"),
    ],
)
def test_what_cannot_be_compensated_is_told(arguments, settings, message):
    with pytest.raises(EcfitError, match=message):
        compensate(*arguments, **settings)


def test_the_methods_make_models_of_their_own():
    assert isinstance(compensate("conductor"), Turquin)
    assert isinstance(compensate("conductor", method="kulla-conty"), KullaConty)


def test_furnace_of_takes_any_model():
    """A model to be compensated, and one that is already."""
    by_name, made = (
        furnace_of(model, ROUGHLY, AXES) for model in (Conductor(), compensate("conductor", ROUGHLY))
    )
    np.testing.assert_allclose(by_name.deviation, made.deviation, rtol=1e-13)
