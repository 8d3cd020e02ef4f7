"""The Enterprise PBR model: identities, its lobes against brute force, its parts against each other."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.compensation import kulla_conty_fresnel
from ecfit.enterprise import EnterprisePBR, Metallic, Opaque, Transparent
from ecfit.enterprise.average import white_average
from ecfit.enterprise.energies import Albedos
from ecfit.errors import EcfitError
from ecfit.quadrature import Hemisphere

MU = jnp.asarray([0.05, 0.4, 1.0])


def directions(count: int = 40, below: bool = False) -> tuple[jax.Array, jax.Array]:
    rng = np.random.default_rng(3)
    z, phi = rng.uniform(0.1, 1.0, (2, count)), rng.uniform(0.0, 2.0 * np.pi, (2, count))
    s = np.sqrt(1.0 - z * z)
    w = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=-1)
    return jnp.asarray(w[0]), jnp.asarray(w[1] * [1.0, 1.0, -1.0 if below else 1.0])


def values(model: ecfit.BSDF, below: bool = False) -> np.ndarray:
    return np.asarray(jax.vmap(model.f)(*directions(below=below)))


def albedo(model: ecfit.BSDF, mu: jax.Array = MU, level: int = 1, lobe: str = "all") -> np.ndarray:
    measure = model.measure()
    return np.asarray(jax.jit(jax.vmap(lambda m: measure.albedo(m, level, lobe).value))(mu))


def by_brute_force(model: ecfit.BSDF, mu: jax.Array) -> np.ndarray:
    rule = Hemisphere(model.f, model.transmissive)
    return np.asarray(jax.jit(jax.vmap(lambda m: rule.albedo(m, 3, "all").value))(mu))


@cache
def oracle_average(alpha: float, count: int = 40) -> float:
    """2 x integral of E_m mu dmu, from `tabulate`."""
    x, w = np.polynomial.legendre.leggauss(count)
    t = 0.5 * (x + 1.0)
    model = ecfit.model("conductor", masking="height-correlated", alpha=alpha)
    return float(2.0 * w @ (t**3 * np.asarray(ecfit.directional_albedo(model, mu=t * t))))


@pytest.mark.parametrize("alpha", [0.003, 0.2, 0.77, 1.0])
def test_the_series_of_the_average_is_the_integral(alpha):
    assert float(white_average(jnp.asarray(alpha))) == pytest.approx(oracle_average(alpha), abs=2e-9)


def test_the_average_of_a_mirror_is_one_and_its_slope_finite():
    assert float(white_average(jnp.asarray(0.0))) == pytest.approx(1.0, abs=1e-9)
    assert np.isfinite(float(jax.grad(white_average)(jnp.asarray(0.0))))


def test_a_white_metal_keeps_all_energy():
    found = albedo(Metallic(alpha=0.64, F0=1.0))
    np.testing.assert_allclose(found, 1.0, atol=1e-9)


def test_the_layer_is_the_split_sum_with_all_later_bounces():
    """F0 A + B + (1 - E_m) F_ms, of lobes that know nothing of the model."""
    alpha, f0 = 0.49, 0.3
    lobe = ecfit.model("conductor", masking="height-correlated", alpha=alpha)
    direct = ecfit.model("conductor", masking="height-correlated", fresnel="schlick", alpha=alpha, F0=f0)
    e1, single = (ecfit.directional_albedo(m, mu=MU) for m in (lobe, direct))
    f_ms = kulla_conty_fresnel(f0 + (1.0 - f0) / 21.0, oracle_average(alpha))
    expected = single + (1.0 - e1) * f_ms
    np.testing.assert_allclose(albedo(Metallic(alpha=alpha, F0=f0)), expected, atol=1e-8)
    albedos = Albedos(jnp.asarray(alpha), jnp.asarray(f0), "exact")
    base = jax.jit(jax.vmap(lambda m: albedos.base(m, 1).value))(MU)
    np.testing.assert_allclose(base, expected, atol=1e-8)


def test_an_average_that_is_not_the_mean_shows_in_the_furnace():
    """Printed fits: E + (1 - E~) (1 - <E~>) / (1 - E~_avg), every term from the formulas alone."""
    alpha = 0.36
    model = Metallic(alpha=alpha, F0=1.0, energy="printed")
    fit = ecfit.published("enterprise-pbr-2019x")
    x, w = np.polynomial.legendre.leggauss(20)
    mu = 0.5 * (x + 1.0)
    mean = float(w @ (mu * np.asarray(fit(alpha=alpha, mu=mu))))
    average = float(ecfit.published("enterprise-pbr-2019x-average")(alpha=alpha))
    assert abs(mean - average) > 1e-3
    lobe = ecfit.model("conductor", masking="height-correlated", alpha=alpha)
    single = ecfit.directional_albedo(lobe, mu=MU)
    expected = single + (1.0 - fit(alpha=alpha, mu=MU)) * (1.0 - mean) / (1.0 - average)
    np.testing.assert_allclose(albedo(model), expected, atol=1e-8)


def test_a_white_opaque_dielectric_keeps_all_energy():
    found = albedo(Opaque(alpha=0.25, ior=1.5, s=0.7), level=0)
    np.testing.assert_allclose(found, 1.0, atol=1e-5)


@pytest.mark.parametrize(
    "model",
    [
        Metallic(alpha=0.5, F0=0.7, energy="printed"),
        Opaque(alpha=0.5, b=0.4, s=0.8, rho=0.9, energy="printed"),
        pytest.param(Transparent(alpha=0.5, s=0.9, rho=0.8, energy="printed"), marks=pytest.mark.slow),
        pytest.param(
            EnterprisePBR(alpha=0.6, m=0.3, t=0.4, b=0.5, rho=0.7, energy="printed"), marks=pytest.mark.slow
        ),
    ],
    ids=lambda m: type(m).__name__,
)
def test_f_integrates_to_the_measure(model):
    mu = jnp.asarray([0.3, 0.9])
    np.testing.assert_allclose(by_brute_force(model, mu), albedo(model, mu, 2), atol=2e-5)


def test_a_thin_sheet_without_compensation_is_the_thin_dielectric():
    sheet = Transparent(alpha=0.4, energy="none")
    other = ecfit.model("thin-dielectric", alpha=0.4, fresnel="schlick", masking="height-correlated")
    for below in (False, True):
        np.testing.assert_allclose(values(sheet, below), values(other, below), rtol=1e-12)


@pytest.mark.parametrize("side", ["entering", "leaving"])
def test_a_boundary_without_compensation_is_the_rough_dielectric(side):
    settings = {"alpha": 0.4, "ior": 1.4, "side": side}
    made = ecfit.model("enterprise-transparent", kind="volumetric", energy="none", **settings)
    other = ecfit.model("dielectric", fresnel="schlick", masking="height-correlated", **settings)
    for below in (False, True):
        np.testing.assert_allclose(values(made, below), values(other, below), rtol=1e-10)
    assert float(made.relative_ior()) == float(other.relative_ior())


def test_total_reflection_ignores_tint_but_not_the_amount():
    """As printed: F_d = 1 beyond the critical angle whatever f0 is, and s scales the whole lobe."""
    settings = {"alpha": 0.05, "ior": 1.5, "kind": "volumetric", "side": "leaving", "energy": "none"}
    grazing = jnp.asarray([0.3])
    plain, tinted, half = (
        albedo(ecfit.model("enterprise-transparent", **settings, **more), grazing, 1, "reflection")
        for more in ({}, {"rho_s": 0.0}, {"s": 0.5})
    )
    np.testing.assert_allclose(tinted, plain, rtol=1e-3)
    np.testing.assert_allclose(half, 0.5 * plain, rtol=1e-9)


def test_the_sum_of_the_three_is_what_the_core_stands_for():
    shared = {"alpha": 0.5, "ior": 1.6, "s": 0.8, "rho_s": 0.6, "rho": 0.7, "energy": "printed"}
    whole = EnterprisePBR(m=0.3, t=0.4, b=0.2, blend="sum", **shared)
    metal = Metallic(alpha=0.5, F0=0.7, energy="printed")
    opaque, clear = Opaque(b=0.2, **shared), Transparent(**shared)
    for below in (False, True):
        expected = 0.3 * values(metal, below)
        expected += 0.7 * (0.6 * values(opaque, below) + 0.4 * values(clear, below))
        np.testing.assert_allclose(values(whole, below), expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("kind", ["thin", "volumetric"])
def test_merging_changes_nothing_where_one_part_stands_alone(kind):
    for m, t in ((1.0, 0.0), (0.0, 0.0), (0.0, 1.0)):
        made = [
            values(EnterprisePBR(alpha=0.5, m=m, t=t, rho=0.6, kind=kind, blend=blend, energy="printed"))
            for blend in ("merged", "sum")
        ]
        np.testing.assert_allclose(*made, rtol=1e-12)


def test_merging_changes_the_multiple_scattering_of_a_mixture():
    made = [values(EnterprisePBR(alpha=0.9, m=0.5, blend=b, energy="printed")) for b in ("merged", "sum")]
    assert np.max(np.abs(made[0] / made[1] - 1.0)) > 1e-3


def test_a_coat_of_no_strength_is_none():
    plain = values(EnterprisePBR(alpha=0.5, energy="printed"))
    coated = values(EnterprisePBR(alpha=0.5, energy="printed", coat="clear", c=0.0))
    np.testing.assert_allclose(coated, plain, rtol=1e-13)


def test_a_coated_black_core_reflects_the_coat_alone():
    settings = {"alpha": 0.5, "rho": 0.0, "s": 0.0, "energy": "none", "coat": "clear", "alpha_c": 0.6}
    made = values(EnterprisePBR(**settings))
    coat = Metallic(alpha=0.36, F0=0.04, energy="none")
    np.testing.assert_allclose(made, values(coat), rtol=1e-12)


def test_a_coat_needs_albedos_in_closed_form():
    with pytest.raises(EcfitError, match="choose energy"):
        EnterprisePBR(coat="clear")


def test_all_parts_are_reciprocal_in_reflection():
    wo, wi = directions()
    for model in (Opaque(alpha=0.5, b=0.5, energy="printed"), EnterprisePBR(energy="printed", coat="clear")):
        np.testing.assert_allclose(jax.vmap(model.f)(wo, wi), jax.vmap(model.f)(wi, wo), rtol=1e-10)
