"""Fresnel factors: textbook values, symmetry of the two sides, and limits."""

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.microfacet import (
    ConductorFresnel,
    DielectricFresnel,
    F82TintFresnel,
    SchlickDielectricFresnel,
    SchlickFresnel,
    UnitFresnel,
)
from ecfit.microfacet.fresnel import refracted_cosine

INDICES = (1.0, 1.05, 1.33, 1.5, 2.4, 4.0)
# Not 0: there F = 1 for every index but 1, and 0 / 0 for that.
X = jnp.asarray(np.linspace(0.001, 1.0, 200))


def dielectric(eta, x):
    return np.asarray(DielectricFresnel(jnp.asarray(eta))(jnp.asarray(x)))


def conductor(eta, k, x):
    return np.asarray(ConductorFresnel(jnp.asarray(eta), jnp.asarray(k))(jnp.asarray(x)))


def by_complex_numbers(n: complex, x: np.ndarray) -> np.ndarray:
    """Fresnel's equations as they stand, in complex arithmetic."""
    transmitted = np.sqrt(1.0 - (1.0 - x**2) / n**2 + 0j)
    s = (x - n * transmitted) / (x + n * transmitted)
    p = (n * x - transmitted) / (n * x + transmitted)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


@pytest.mark.parametrize("eta", [*INDICES, 1 / 1.5, 1 / 3])
def test_normal_incidence_has_the_closed_form(eta):
    assert dielectric(eta, 1.0) == pytest.approx(((eta - 1) / (eta + 1)) ** 2, rel=1e-13, abs=1e-30)


@pytest.mark.parametrize("eta", [*INDICES, 1 / 1.5])
def test_a_dielectric_agrees_with_complex_arithmetic(eta):
    np.testing.assert_allclose(dielectric(eta, X), by_complex_numbers(eta, np.asarray(X)), atol=1e-14)


@pytest.mark.parametrize(("eta", "k"), [(0.2, 3.9), (1.5, 0.5), (0.05, 0.0), (3.0, 3.3), (20.0, 30.0)])
def test_a_conductor_agrees_with_complex_arithmetic(eta, k):
    np.testing.assert_allclose(
        conductor(eta, k, X), by_complex_numbers(eta + 1j * k, np.asarray(X)), atol=1e-13
    )


def test_gold_in_the_red_reflects_as_published():
    # eta + i k of gold at 652.5 nm (Johnson & Christy 1972): 0.166 + 3.15 i.
    expected = ((0.166 - 1) ** 2 + 3.15**2) / ((0.166 + 1) ** 2 + 3.15**2)
    assert conductor(0.166, 3.15, 1.0) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("eta", [1.33, 1.5, 2.4])
def test_at_brewsters_angle_only_s_polarised_light_is_reflected(eta):
    x = 1.0 / np.sqrt(1.0 + eta**2)  # tan(theta) = eta
    assert dielectric(eta, x) == pytest.approx(0.5 * ((eta**2 - 1) / (eta**2 + 1)) ** 2, rel=1e-12)


@pytest.mark.parametrize("eta", [1 / 1.05, 1 / 1.5, 0.3])
def test_total_internal_reflection_begins_at_the_critical_angle(eta):
    critical = np.sqrt(1.0 - eta**2)
    assert np.all(dielectric(eta, np.linspace(0.0, critical * (1 - 1e-12), 50)) == 1.0)
    assert dielectric(eta, critical + 1e-6) < 1.0


@pytest.mark.parametrize("eta", INDICES)
def test_both_sides_of_an_interface_reflect_alike(eta):
    refracted = np.sqrt(1.0 - (1.0 - np.asarray(X) ** 2) / eta**2)
    np.testing.assert_allclose(dielectric(1.0 / eta, refracted), dielectric(eta, X), atol=1e-12)


def test_equal_indices_reflect_nothing():
    assert dielectric(1.0, X).max() < 1e-20


@pytest.mark.parametrize("eta", [1.0, 1.5, 3.0, 1 / 1.5])
def test_a_conductor_without_absorption_is_a_dielectric(eta):
    np.testing.assert_allclose(conductor(eta, 0.0, X), dielectric(eta, X), atol=1e-13)


@pytest.mark.parametrize("make", [lambda: dielectric(1.5, 0.0), lambda: conductor(0.2, 3.9, 0.0)])
def test_grazing_light_is_reflected_whole(make):
    assert make() == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize(
    "fresnel",
    [
        DielectricFresnel(jnp.asarray(1.5)),
        DielectricFresnel(jnp.asarray(0.6)),
        ConductorFresnel(jnp.asarray(0.2), jnp.asarray(3.9)),
        SchlickFresnel(jnp.asarray(0.04), jnp.asarray(1.0)),
        SchlickDielectricFresnel(jnp.asarray(1.5), jnp.asarray(1.0)),
        SchlickDielectricFresnel(jnp.asarray(0.6), jnp.asarray(1.0)),
        DielectricFresnel(jnp.asarray(1.5)).complement(),
        UnitFresnel(),
    ],
    ids=[
        "entering",
        "leaving",
        "conductor",
        "schlick",
        "schlick-entering",
        "schlick-leaving",
        "complement",
        "unit",
    ],
)
def test_reflectance_lies_in_the_unit_interval_and_has_finite_slopes(fresnel):
    x = jnp.linspace(0.0, 1.0, 301)
    value, slope = jax.jit(jax.vmap(jax.value_and_grad(fresnel)))(x)
    assert float(jnp.min(value)) >= 0.0
    assert float(jnp.max(value)) <= 1.0 + 1e-15
    assert np.all(np.isfinite(slope))


def test_gradients_in_the_index_are_finite_under_total_reflection():
    slope = jax.grad(lambda eta: DielectricFresnel(eta)(jnp.asarray(0.3)))(0.6)
    assert float(slope) == 0.0


@pytest.mark.parametrize(("eta", "k", "x"), [(0.2, 3.9, 0.5), (1.5, 0.7, 0.1), (3.0, 2.0, 1.0)])
def test_gradients_in_a_conductors_index_agree_with_differences(eta, k, x):
    def value(e, kk):
        return ConductorFresnel(e, kk)(jnp.asarray(x))

    h = 1e-6
    by_eta, by_k = jax.grad(value, (0, 1))(eta, k)
    assert float(by_eta) == pytest.approx(float(value(eta + h, k) - value(eta - h, k)) / (2 * h), abs=1e-8)
    assert float(by_k) == pytest.approx(float(value(eta, k + h) - value(eta, k - h)) / (2 * h), abs=1e-8)


def test_schlick_takes_F0_at_the_normal_and_F90_at_grazing():
    schlick = SchlickFresnel(jnp.asarray(0.04), jnp.asarray(0.9))
    assert float(schlick(jnp.asarray(1.0))) == 0.04
    assert float(schlick(jnp.asarray(0.0))) == pytest.approx(0.9, rel=1e-15)
    # Schlick 1994, eq. 15, by hand at x = 1/2.
    assert float(schlick(jnp.asarray(0.5))) == pytest.approx(0.04 + 0.86 / 32, rel=1e-15)


def test_unit_reflects_everything():
    assert np.all(np.asarray(UnitFresnel()(X)) == 1.0)


@pytest.mark.parametrize("eta", [*INDICES, 1 / 1.5])
def test_the_refracted_cosine_obeys_snells_law(eta):
    c, refracts = (np.asarray(v) for v in refracted_cosine(jnp.asarray(eta), X))
    sine = np.sqrt(1.0 - np.asarray(X) ** 2)
    np.testing.assert_array_equal(refracts, sine < eta)
    np.testing.assert_allclose(eta * np.sqrt(1.0 - c[refracts] ** 2), sine[refracts], atol=1e-12)
    np.testing.assert_array_equal(c[~refracts], 1.0)


def test_into_an_infinite_index_light_is_refracted_to_the_normal_but_wholly_reflected():
    """F0 = 1 on an axis is this index: neither NaN nor a warning may come of it."""
    c, refracts = refracted_cosine(jnp.asarray(jnp.inf), jnp.asarray([0.0, 0.5, 1.0]))
    np.testing.assert_array_equal(c, 1.0)
    assert np.all(np.asarray(refracts))
    for factor in (DielectricFresnel, lambda eta: SchlickDielectricFresnel(eta, jnp.asarray(1.0))):
        np.testing.assert_array_equal(factor(jnp.asarray(jnp.inf))(jnp.asarray([0.0, 0.5, 1.0])), 1.0)


def test_a_large_index_is_near_the_infinite_one():
    """At normal incidence 1 - F = 4 eta / (1 + eta)^2."""
    np.testing.assert_allclose(1.0 - dielectric(1e8, 1.0), 4e-8, rtol=1e-6)


def test_schlick_for_an_interface_has_the_F0_of_its_index():
    factor = SchlickDielectricFresnel(jnp.asarray(1.5), jnp.asarray(0.9))
    plain = SchlickFresnel(jnp.asarray(0.04), jnp.asarray(0.9))
    np.testing.assert_allclose(factor(X), plain(X), rtol=1e-14)


def test_schlick_seen_from_inside_takes_the_cosine_outside():
    """Both sides of an interface reflect alike; beyond the critical angle all is reflected."""
    outside, inside = (SchlickDielectricFresnel(jnp.asarray(eta), jnp.asarray(1.0)) for eta in (1.5, 1 / 1.5))
    refracted = jnp.sqrt(1.0 - (1.0 - X**2) / 1.5**2)
    np.testing.assert_allclose(inside(refracted), outside(X), atol=1e-13)
    critical = np.sqrt(1.0 - 1.0 / 1.5**2)
    np.testing.assert_array_equal(inside(jnp.linspace(0.0, critical * (1.0 - 1e-12), 50)), 1.0)


def test_the_complement_is_what_passes():
    factor = DielectricFresnel(jnp.asarray(1.5))
    np.testing.assert_allclose(factor.complement()(X), 1.0 - np.asarray(factor(X)), rtol=1e-15)
    np.testing.assert_allclose(factor.complement().complement()(X), factor(X), atol=1e-15)


def test_schlicks_exponent_is_free():
    # By hand at x = 1/2: 0.2 + 0.8 / 2^7.
    found = SchlickFresnel(jnp.asarray(0.2), jnp.asarray(1.0), 7)(jnp.asarray(0.5))
    assert float(found) == pytest.approx(0.2 + 0.8 / 128, rel=1e-15)


@pytest.mark.parametrize(("f0", "tint"), [(0.04, 0.3), (0.9, 0.0), (0.5, 1.0)])
def test_the_tint_is_what_is_left_of_schlick_at_82_degrees(f0, tint):
    factor = F82TintFresnel(jnp.asarray(f0), jnp.asarray(tint))
    schlick = SchlickFresnel(jnp.asarray(f0), jnp.asarray(1.0))
    x = jnp.asarray([0.0, 1.0 / 7.0, 1.0])
    np.testing.assert_allclose(factor(x), schlick(x) * jnp.asarray([1.0, tint, 1.0]), atol=1e-14)
    # Elsewhere it is tinted less: a tint of 1 is Schlick's factor everywhere.
    np.testing.assert_array_less(-1e-14, schlick(X) - factor(X))
    assert (np.abs(schlick(X) - factor(X)).max() < 1e-14) == (tint == 1.0)
