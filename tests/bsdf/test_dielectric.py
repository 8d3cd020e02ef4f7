"""Dielectrics: f against the measure, the two sides of one interface, and the sheet without refraction."""

from functools import cache

import equinox as eqx
import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import Dielectric, ThinDielectric
from ecfit.errors import EcfitError
from ecfit.microfacet import DielectricFresnel, SchlickDielectricFresnel
from ecfit.quadrature import Hemisphere

SIDES = ("entering", "leaving")
each_side = pytest.mark.parametrize("side", SIDES)


def directions(count: int, seed: int, side: float = 1.0) -> np.ndarray:
    """Unit vectors on one hemisphere, shape (count, 3)."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(0.01, 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    s = np.sqrt(1.0 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), side * z], axis=-1)


WO, ABOVE, BELOW = directions(300, 1), directions(300, 2), directions(300, 3, -1.0)
ABOVE, BELOW, WO = (jnp.asarray(v) for v in (ABOVE, BELOW, WO))


@eqx.filter_jit
def _f(model, wo, wi):
    return jax.vmap(model.f)(wo, wi)


def values(model, wo, wi) -> np.ndarray:
    """f at pairs of directions; models that differ in numbers only share a compilation."""
    return np.asarray(_f(model, wo, wi))


@cache
def by_f(
    model_name: str, settings: tuple[tuple[str, str], ...], alphas: tuple[float, ...], lobe: str, level: int
):
    """The lobe of f itself by the general rule, shape (alphas, mu)."""

    def one(alpha, mu):
        model = ecfit.model(model_name, **dict(settings)).with_parameters({"alpha": alpha})
        return Hemisphere(model.f, True).albedo(mu, level, lobe)

    found = jax.jit(jax.vmap(jax.vmap(one, (None, 0)), (0, None)))(jnp.asarray(alphas), MU)
    return np.asarray(found.value)


MU = jnp.asarray([0.2, 0.6, 1.0])
ROUGH = (0.5, 1.0)


@pytest.mark.parametrize(
    ("side", "lobe", "level", "tolerance"),
    [
        ("entering", "reflection", 3, 1e-6),
        # Refracted light fills a cone only, and F has a root at the critical angle: bends between the panels.
        pytest.param("entering", "transmission", 3, 5e-3, marks=pytest.mark.slow),
        pytest.param("leaving", "reflection", 3, 5e-3, marks=pytest.mark.slow),
        ("leaving", "transmission", 3, 5e-3),
    ],
)
@pytest.mark.parametrize(
    ("ndf", "masking"),
    [("ggx", "separable"), pytest.param("beckmann", "height-correlated-beta", marks=pytest.mark.slow)],
)
def test_f_integrates_to_the_measure(side, lobe, level, tolerance, ndf, masking):
    """The measure is in half vectors and never evaluates f; T is the radiance BSDF's."""
    settings = (("side", side), ("ndf", ndf), ("masking", masking))
    expected = ecfit.directional_albedo(
        ecfit.model("dielectric", **dict(settings)),
        mu=MU,
        alpha=jnp.asarray(ROUGH)[:, None],
        lobe=lobe,
        transport="radiance",
    )
    np.testing.assert_allclose(by_f("dielectric", settings, ROUGH, lobe, level), expected, atol=tolerance)


@each_side
@pytest.mark.parametrize("alpha", [0.0, 1e-3, 0.5, 1.0])
def test_f_is_finite_and_not_negative(side, alpha):
    model = ecfit.model("dielectric", side=side, alpha=alpha)
    for wi in (ABOVE, BELOW):
        found = values(model, WO, wi)
        assert np.all(np.isfinite(found))
        assert found.min() >= 0.0


@each_side
@pytest.mark.parametrize("masking", ["separable", "height-correlated-beta"])
def test_reflection_is_reciprocal(side, masking):
    model = ecfit.model("dielectric", side=side, alpha=0.6, masking=masking)
    np.testing.assert_allclose(values(model, WO, ABOVE), values(model, ABOVE, WO), rtol=1e-11)


@pytest.mark.parametrize("fresnel", ["exact", "schlick"])
@pytest.mark.parametrize("masking", ["separable", "height-correlated", "height-correlated-beta"])
def test_transmission_is_reciprocal_up_to_the_indices_squared(fresnel, masking):
    """f(wo, wi) n_i^2 = f(wi, wo) n_o^2, with f what its first direction sees of light from the second.

    Radiance grows with n^2 across the interface (Veach 1997). Here n_o = 1 (wo outside) and n_i = 1.5.
    """
    ior = 1.5
    entering, leaving = (
        ecfit.model("dielectric", side=side, alpha=0.6, ior=ior, masking=masking, fresnel=fresnel)
        for side in SIDES
    )
    turned = jnp.asarray([1.0, 1.0, -1.0])  # the leaving model's normal points inside
    there = values(entering, WO, BELOW)
    back = values(leaving, BELOW * turned, WO * turned)
    assert np.count_nonzero(there) > 50
    np.testing.assert_allclose(there * ior**2, back, rtol=1e-9)


@each_side
def test_equal_indices_leave_no_lobe_that_f_could_hold(side):
    """All light goes straight on: a delta function."""
    model = ecfit.model("dielectric", side=side, ior=1.0, alpha=0.5)
    assert values(model, WO, ABOVE).max() < 1e-20
    np.testing.assert_array_equal(values(model, WO, BELOW), 0.0)


@each_side
def test_gradients_of_f_are_finite_on_both_sides(side):
    def value(alpha, ior, wo, wi):
        return Dielectric(side=side).with_parameters({"alpha": alpha, "ior": ior}).f(wo, wi)

    slope = jax.jit(jax.vmap(jax.grad(value, (0, 1)), (None, None, 0, 0)))
    for wi in (ABOVE, BELOW):
        for ior in (1.0, 1.5):
            assert np.all(np.isfinite(slope(0.3, ior, WO, wi)))


@pytest.mark.parametrize("side", [pytest.param("entering", marks=pytest.mark.slow), "leaving"])
def test_the_beta_masking_is_another_for_transmission_only(side):
    R, T = (
        [
            float(
                ecfit.directional_albedo(
                    Dielectric(side=side, masking=masking), mu=0.4, alpha=0.8, lobe=lobe, level=0
                )
            )
            for masking in ("height-correlated", "height-correlated-beta")
        ]
        for lobe in ("reflection", "transmission")
    )
    assert R[0] == R[1]
    assert T[1] < T[0] - 0.01


@each_side
def test_the_fresnel_option_chooses_the_factor(side):
    exact, schlick = (Dielectric(side=side, fresnel=name, F90=0.9) for name in ("exact", "schlick"))
    eta = jnp.asarray(1.5 if side == "entering" else 1.0 / 1.5)
    x = jnp.linspace(0.0, 1.0, 30)
    np.testing.assert_allclose(exact.fresnel_factor()(x), DielectricFresnel(eta)(x), atol=1e-15)
    expected = SchlickDielectricFresnel(eta, jnp.asarray(0.9))(x)
    np.testing.assert_allclose(schlick.fresnel_factor()(x), expected, atol=1e-15)


@pytest.mark.parametrize("model", [Dielectric, ThinDielectric])
def test_F90_matters_to_schlick_alone(model):
    assert model().active_parameters() == ("alpha", "ior")
    assert model(fresnel="schlick").active_parameters() == ("alpha", "ior", "F90")


def test_a_smooth_surface_with_schlicks_factor_reflects_what_it_says():
    mu = np.array([0.1, 0.5, 1.0])
    model = ecfit.model("dielectric", fresnel="schlick", F90=0.8, ior=1.5, alpha=0.0)
    R = ecfit.directional_albedo(model, mu=mu, lobe="reflection", level=0)
    np.testing.assert_allclose(R, 0.04 + 0.76 * (1.0 - mu) ** 5, atol=1e-9)


def test_the_critical_angle_is_told_to_averages():
    """Seen from inside E turns there; from outside nowhere."""
    np.testing.assert_allclose(
        Dielectric(side="leaving").albedo_kinks(), [np.sqrt(1.0 - 1.0 / 1.5**2)], rtol=1e-15
    )
    assert Dielectric(side="entering").albedo_kinks().size == 0
    none = Dielectric(side="leaving", ior=1.0)
    np.testing.assert_array_equal(none.albedo_kinks(), 0.0)
    slope = jax.grad(lambda ior: Dielectric(side="leaving", ior=ior).albedo_kinks()[0])(1.0)
    assert np.isfinite(slope)


def test_a_thin_sheets_lobes_add_up_to_a_white_conductor():
    """Whatever the Fresnel factor: what is not reflected leaves on the other side by the same lobe."""
    at = {"mu": MU, "alpha": jnp.asarray(ROUGH)[:, None], "level": 1}
    white = ecfit.directional_albedo("conductor", **at)
    for fresnel in ("exact", "schlick"):
        model = ThinDielectric(fresnel=fresnel, ior=2.0)
        R, T, both = (
            np.asarray(ecfit.directional_albedo(model, lobe=lobe, **at))
            for lobe in ("reflection", "transmission", "all")
        )
        np.testing.assert_allclose(R + T, white, rtol=1e-13)
        np.testing.assert_allclose(both, white, rtol=1e-14)
        assert 0.03 < R.min() < R.max() < 0.95 * both.max()


def test_a_thin_sheet_transmits_the_mirror_image_of_what_it_reflects():
    """The same D and G2: the ratio of both lobes is F / (1 - F)."""
    model = ecfit.model("thin-dielectric", alpha=0.6, ior=2.0)
    mirrored = ABOVE * jnp.asarray([1.0, 1.0, -1.0])
    reflected, passed = values(model, WO, ABOVE), values(model, WO, mirrored)
    h = np.asarray(WO + ABOVE)
    x = np.sum(np.asarray(WO) * h / np.linalg.norm(h, axis=-1, keepdims=True), axis=-1)
    factor = np.asarray(DielectricFresnel(jnp.asarray(2.0))(jnp.asarray(x)))
    np.testing.assert_allclose(reflected * (1.0 - factor), passed * factor, rtol=1e-9)
    np.testing.assert_allclose(
        passed,
        values(model, mirrored * jnp.asarray([1.0, 1.0, -1.0]), WO * jnp.asarray([1.0, 1.0, -1.0])),
        rtol=1e-9,
    )


@pytest.mark.parametrize("lobe", ["reflection", "transmission"])
def test_f_of_a_thin_sheet_integrates_to_its_measure(lobe):
    expected = ecfit.directional_albedo(
        "thin-dielectric", mu=MU, alpha=jnp.asarray(ROUGH)[:, None], lobe=lobe
    )
    np.testing.assert_allclose(by_f("thin-dielectric", (), ROUGH, lobe, 3), expected, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "model", [Dielectric(), Dielectric(side="leaving"), ThinDielectric()], ids=["entering", "leaving", "thin"]
)
def test_the_models_keep_their_promises(model):
    found = ecfit.check_bsdf(model, samples=100)
    assert found, str(found)


@pytest.mark.parametrize(
    ("name", "option", "value"),
    [
        ("dielectric", "side", "inside"),
        ("dielectric", "masking", "none"),
        ("dielectric", "fresnel", "unit"),
        ("dielectric", "ndf", "phong"),
        ("thin-dielectric", "masking", "height-correlated-beta"),
        ("thin-dielectric", "side", "entering"),
    ],
)
def test_unknown_options_are_refused(name, option, value):
    with pytest.raises(EcfitError, match=option):
        ecfit.model(name, **{option: value})


@pytest.mark.parametrize("ior", [0.9, 101.0])
def test_an_index_outside_the_range_is_refused(ior):
    with pytest.raises(EcfitError, match="'ior'"):
        ecfit.model("dielectric", ior=ior)
