"""Moments of the reflection lobe, from which other Fresnel factors follow, and the average of a factor."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.errors import EcfitError
from ecfit.microfacet import ConductorFresnel, DielectricFresnel, Fresnel
from ecfit.quantities import F82Moment, SchlickA, quantity

# Not grazing and not smooth: each level more, which those need, is a compilation for every quantity.
MU, R = [0.2, 0.4, 1.0], [0.4, 0.7]
AXES = {"r": R, "mu": MU}


@cache
def table(name: str, exponent: int | None = None, model: str = "conductor") -> np.ndarray:
    options = {} if exponent is None else {"exponent": exponent}
    found = ecfit.tabulate(model, AXES, quantity=name, tolerance=1e-9, quantity_options=options)
    assert np.all(found.status == 0)
    return found.values


@cache
def albedo(**settings) -> np.ndarray:
    return ecfit.tabulate(ecfit.model("conductor", **settings), AXES, tolerance=1e-9).values


def test_A_and_B_add_up_to_the_white_albedo():
    np.testing.assert_allclose(table("schlick-a") + table("schlick-b"), albedo(), atol=1e-9)


@pytest.mark.parametrize(("F0", "F90"), [(0.04, 1.0), (0.9, 1.0), (0.3, 0.6)])
def test_two_moments_serve_every_F0_and_F90(F0, F90):
    expected = albedo(fresnel="schlick", F0=F0, F90=F90)
    np.testing.assert_allclose(F0 * table("schlick-a") + F90 * table("schlick-b"), expected, atol=1e-9)


def test_the_exponent_is_that_of_the_moment(reference_albedo):
    """Integrated over directions of light, with nothing of ecfit."""
    expected = reference_albedo("ggx", "separable", 0.4, 0.49, lambda x: (1.0 - x) ** 7)
    found = ecfit.tabulate(
        "conductor",
        {"r": R, "mu": MU},
        quantity="schlick-b",
        quantity_options={"exponent": 7},
        tolerance=1e-9,
    )
    assert found.values[1, 1] == pytest.approx(expected, abs=1e-9)
    np.testing.assert_array_equal(table("schlick-b", 5), table("schlick-b"))


def test_the_f82_moment_agrees_with_integration_over_directions(reference_albedo):
    found = table("f82-moment")
    for i, r in enumerate(R):
        for j, mu in enumerate(MU[:2]):
            expected = reference_albedo("ggx", "separable", mu, r * r, lambda x: x * (1.0 - x) ** 6)
            assert found[i, j] == pytest.approx(expected, abs=1e-9)


def test_the_f82_model_follows_from_three_moments(reference_albedo):
    """F = F0 + (1 - F0) (1 - x)^5 - b x (1 - x)^6 (Kutz et al. 2021), any b."""
    F0, b, mu, r = 0.9, 0.8, MU[1], R[1]
    expected = reference_albedo(
        "ggx", "separable", mu, r * r, lambda x: F0 + (1.0 - F0) * (1.0 - x) ** 5 - b * x * (1.0 - x) ** 6
    )
    A, B, C = (table(n)[1, 1] for n in ("schlick-a", "schlick-b", "f82-moment"))
    assert F0 * A + B - b * C == pytest.approx(expected, abs=1e-9)


def test_a_moment_does_not_depend_on_the_fresnel_factor():
    """Its parameters have no effect, and an axis of one is refused."""
    model = ecfit.model("conductor", fresnel="exact", eta=1.5, k=2.0)
    found = ecfit.tabulate(model, AXES, quantity="schlick-b", tolerance=1e-9)
    np.testing.assert_allclose(found.values, table("schlick-b"), rtol=1e-14)
    assert found.contract.parameters == {}
    with pytest.raises(EcfitError, match="'k' has no effect on this quantity"):
        ecfit.tabulate(model, {"k": [1.0, 2.0], **AXES}, quantity="schlick-b")


@pytest.mark.parametrize("name", ["schlick-a", "schlick-b", "f82-moment"])
@pytest.mark.parametrize("model", ["lambertian", "dielectric", "glossy"])
def test_moments_are_for_one_reflection_lobe(name, model):
    with pytest.raises(EcfitError, match=r"moments of wo\.h are defined for models such as 'conductor'"):
        ecfit.tabulate(model, {"mu": [0.2, 0.8]}, quantity=name)


@pytest.mark.parametrize("exponent", [0, 51, -1, 5.0, True, "5", None])
def test_an_exponent_is_a_small_positive_integer(exponent):
    with pytest.raises(EcfitError, match="exponent"):
        SchlickA(exponent=exponent)


def test_a_quantity_takes_its_own_settings_only():
    assert quantity("schlick-a", exponent=6).options() == {"exponent": 6}
    assert F82Moment().options() == {}
    with pytest.raises(EcfitError, match="'f82-moment' does not take exponent"):
        quantity("f82-moment", exponent=6)
    with pytest.raises(EcfitError, match="'directional-albedo' does not take colour"):
        quantity("directional-albedo", colour=1)


def averaged(factor: Fresnel, panels, critical: float = 0.0) -> float:
    """2 x integral of F(x) x dx, on panels that halve towards grazing and the critical cosine."""
    x, w = panels([0.0, critical, 1.0] if critical else [0.0, 1.0], 40, 16)
    return float(2.0 * w @ (np.asarray(factor(jnp.asarray(x))) * x))


def average(model, **axes) -> ecfit.Table:
    return ecfit.tabulate(model, axes, quantity="average-fresnel", tolerance=1e-8)


INDICES = [1.0, 1.0001, 1.01, 1.33, 1.5, 3.0, 100.0]


@pytest.mark.parametrize("side", ["entering", "leaving"])
def test_the_average_of_a_dielectric_is_its_integral(side, panels):
    found = average(ecfit.model("dielectric", side=side), ior=INDICES)
    assert np.all(found.status == 0)
    for n, value, error in zip(INDICES, found.values, found.errors, strict=True):
        eta, critical = (n, 0.0) if side == "entering" else (1.0 / n, np.sqrt(1.0 - 1.0 / n**2))
        expected = averaged(DielectricFresnel(jnp.asarray(eta)), panels, critical)
        assert value == pytest.approx(expected, abs=1e-8)
        assert abs(value - expected) <= error + 1e-12


def test_the_averages_of_both_sides_tell_one_energy():
    """What diffuse light loses on its way in and out is the same etendue: 1 - F_in = n^2 (1 - F_out)."""
    entering, leaving = (
        average(ecfit.model("dielectric", side=s), ior=INDICES) for s in ("entering", "leaving")
    )
    np.testing.assert_allclose(1.0 - leaving.values, (1.0 - entering.values) / np.square(INDICES), atol=1e-8)
    assert entering.values[0] == pytest.approx(0.0, abs=1e-9)
    assert leaving.values[0] == pytest.approx(0.0, abs=1e-9)


def test_the_average_of_schlicks_factor_has_a_closed_form():
    """2 x integral of (1 - x)^5 x dx = 1 / 21."""
    F0 = np.array([0.0, 0.04, 0.5, 1.0])
    found = average(ecfit.model("conductor", fresnel="schlick", F90=0.9), F0=F0)
    np.testing.assert_allclose(found.values, F0 + (0.9 - F0) / 21.0, atol=1e-12)


def test_the_average_of_a_conductor_is_its_integral(panels):
    """Without absorption there is a critical cosine that the rule does not know of: it must say so."""
    found = average(ecfit.model("conductor", fresnel="exact", eta=0.2), k=[0.0, 0.1, 3.9])
    critical = np.sqrt(1.0 - 0.2**2)
    for k, value, error in zip((0.0, 0.1, 3.9), found.values, found.errors, strict=True):
        expected = averaged(ConductorFresnel(jnp.asarray(0.2), jnp.asarray(k)), panels, critical)
        assert abs(value - expected) <= error + 1e-12
    assert found.errors[-1] <= 1e-8


def test_an_index_of_infinity_reflects_everything_on_average():
    found = average(ecfit.model("glossy"), F0=[0.0, 0.04, 1.0])
    np.testing.assert_allclose(found.values[[0, 2]], [0.0, 1.0], atol=1e-9)


def test_an_average_does_not_depend_on_roughness_or_direction():
    with pytest.raises(EcfitError, match="'alpha' has no effect on this quantity"):
        average("dielectric", alpha=[0.2, 0.5])
    with pytest.raises(EcfitError, match="mu"):
        average("dielectric", ior=[1.2, 1.5], mu=[0.2, 0.5])


def test_a_model_without_a_factor_has_no_average():
    with pytest.raises(EcfitError, match="Lambertian has no Fresnel factor"):
        average("lambertian", rho=[0.2, 0.5])
