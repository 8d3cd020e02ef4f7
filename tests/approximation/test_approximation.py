"""Approximations: coordinates in any view, gradients, and files that read back exactly."""

import json

import jax
import numpy as np
import pytest

import ecfit
from ecfit.approximation import published_names
from ecfit.contract import Contract
from ecfit.forms import Terms


@pytest.fixture(scope="module")
def conductor() -> ecfit.Approximation:
    return ecfit.published("sforza-pellacini-2022-conductor")


def test_the_printed_fit_has_its_printed_corner(conductor: ecfit.Approximation):
    # At r = mu = 0 only the constants remain: a0 / 1.
    assert float(conductor(r=0.0, mu=0.0)) == 1.0247


def test_any_view_of_a_coordinate_gives_the_same(conductor: ecfit.Approximation):
    mu = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(conductor(mu=mu, r=0.5), conductor(mu=mu, alpha=0.25), rtol=1e-15)
    assert conductor(mu=mu[:, None], r=np.array([0.2, 0.4])).shape == (5, 2)


@pytest.mark.parametrize(
    ("coordinates", "words"),
    [({"mu": 0.5}, "'r' is missing"), ({"mu": 0.5, "r": 0.5, "alpha": 0.2}, "more than once"),
     ({"mu": 0.5, "r": 0.5, "F0": 0.2}, "not used")],
)  # fmt: skip
def test_wrong_coordinates_are_refused(conductor: ecfit.Approximation, coordinates, words: str):
    with pytest.raises(ecfit.EcfitError, match=words):
        conductor(**coordinates)


def test_jit_vmap_and_grad(conductor: ecfit.Approximation):
    def value(mu, alpha):
        return conductor(mu=mu, alpha=alpha)

    slope = jax.jit(jax.vmap(jax.grad(value), (0, None)))(np.array([0.3, 0.7]), 0.2)
    step = 1e-6
    for mu, s in zip((0.3, 0.7), slope, strict=True):
        difference = (value(mu + step, 0.2) - value(mu - step, 0.2)) / (2.0 * step)
        assert float(s) == pytest.approx(float(difference), rel=1e-6)


def test_a_file_reads_back_exactly(conductor: ecfit.Approximation):
    again = ecfit.Approximation.from_dict(json.loads(json.dumps(conductor.to_dict())))
    assert again.to_dict() == conductor.to_dict()
    np.testing.assert_array_equal(again.coefficients, conductor.coefficients)


@pytest.mark.parametrize(
    ("key", "value"),
    [("coefficients", [1.0]), ("coefficients", ["x"] * 19), ("coefficients", None), ("domain", [[0, 1]]),
     ("domain", [[1, 0], [0, 1]]), ("variables", "r"), ("numerator_exponents", [[1.5, 0]]), ("contract", {}),
     ("contract", {"model": "m", "transport": "heat"}), ("contract", {"model": "m", "colour": "red"})],
)  # fmt: skip
def test_a_damaged_file_is_refused(conductor: ecfit.Approximation, key: str, value):
    data = conductor.to_dict() | {key: value}
    with pytest.raises(ecfit.EcfitError):
        ecfit.Approximation.from_dict(data)
    with pytest.raises(ecfit.EcfitError, match=key):
        ecfit.Approximation.from_dict({k: v for k, v in conductor.to_dict().items() if k != key})


def test_coefficients_must_be_finite(conductor: ecfit.Approximation):
    with pytest.raises(ecfit.EcfitError, match="finite"):
        conductor.with_quotient(values=np.full(19, np.nan))


# Origin and unit of each variable: what turns (r, mu) into other numbers of the same place.
SCALES = ((0.2, 0.5), (-1.0, 2.0))


def test_other_scales_are_the_same_function_with_other_coefficients(conductor: ecfit.Approximation):
    scaled = conductor.in_scales(SCALES)
    assert scaled.scales == SCALES
    assert not np.allclose(scaled.coefficients, conductor.coefficients)
    mu, r = np.linspace(0.0, 1.0, 7)[:, None], np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(scaled(r=r, mu=mu), conductor(r=r, mu=mu), rtol=1e-11)


def test_scaled_monomials_are_those_of_the_scaled_coordinates():
    """2 + 3 t with t = (x - 1) / 4 is 3.5 at x = 3."""
    terms = Terms(np.array([[0], [1]]), np.zeros((0, 1), dtype=int))
    made = ecfit.Approximation.quotient(
        "x", "polynomial", "1", ("r",), terms, np.array([2.0, 3.0]), ((0.0, 1.0),), Contract("m"),
        scales=((1.0, 4.0),),
    )  # fmt: skip
    assert float(made(r=3.0)) == pytest.approx(3.5, rel=1e-15)
    np.testing.assert_allclose(made.in_scales([(0.0, 1.0)]).coefficients, [1.25, 0.75], rtol=1e-15)


def test_scales_go_there_and_back(conductor: ecfit.Approximation):
    again = conductor.in_scales(SCALES).in_scales(conductor.scales)
    np.testing.assert_allclose(again.coefficients, conductor.coefficients, rtol=1e-9, atol=1e-10)


def test_scales_survive_the_file(conductor: ecfit.Approximation):
    scaled = conductor.in_scales(SCALES)
    again = ecfit.Approximation.from_dict(json.loads(json.dumps(scaled.to_dict())))
    assert again.scales == SCALES
    assert again.to_dict() == scaled.to_dict()


def test_a_file_without_scales_is_in_plain_coordinates(conductor: ecfit.Approximation):
    data = {k: v for k, v in conductor.to_dict().items() if k != "scales"}
    assert ecfit.Approximation.from_dict(data).scales == ((0.0, 1.0),) * 2


@pytest.mark.parametrize(
    "scales",
    [((0.0, 1.0),), ((0.0, 1.0), (0.0, 0.0)), ((0.0, 1.0), (np.inf, 1.0)), ((0.0, 1.0), (0.0, -1.0))],
)
def test_scales_without_meaning_are_refused(conductor: ecfit.Approximation, scales):
    with pytest.raises(ecfit.EcfitError, match="scales"):
        conductor.with_quotient(scales=scales)


def test_an_origin_on_a_pole_is_refused():
    """1 / (1 - 2 r) has no constant 1 in its denominator at r = 1/2."""
    terms = Terms(np.array([[0]]), np.array([[1]]))
    made = ecfit.Approximation.quotient(
        "x", "rational", "0/1", ("r",), terms, np.array([1.0, -2.0]), ((0.0, 0.4),), Contract("m")
    )
    with pytest.raises(ecfit.EcfitError, match="vanishes at the new origin"):
        made.in_scales([(0.5, 1.0)])


@pytest.mark.parametrize("scales", [((0.0, 1.0), (0.0, 1.0)), SCALES])
def test_a_grid_is_evaluated_as_its_points_are(conductor: ecfit.Approximation, scales):
    scaled = conductor.in_scales(scales)
    r, mu = np.linspace(0.0, 1.0, 6), np.linspace(0.1, 0.9, 4)
    np.testing.assert_allclose(scaled.on_grid([r, mu]), scaled(r=r[:, None], mu=mu), rtol=1e-12)


def test_the_smallest_denominator_is_told_in_true_coordinates(conductor: ecfit.Approximation):
    """In units of the constant 1, which is Q at the origin of the scales."""
    plain, scaled = conductor.smallest_denominator(), conductor.in_scales(SCALES).smallest_denominator()
    origin = conductor.denominator(r=SCALES[0][0], mu=SCALES[1][0])
    assert scaled.place == pytest.approx(plain.place, abs=1e-3)
    assert scaled.value == pytest.approx(plain.value / float(origin), rel=1e-6)


def test_an_unknown_published_fit_lists_the_known_ones():
    assert published_names()
    with pytest.raises(ecfit.EcfitError, match=published_names()[0]):
        ecfit.published("sforza-pelacini-2022-conductor")


@pytest.mark.parametrize("name", published_names())
def test_published_fits_have_a_source_and_a_contract(name: str):
    fit = ecfit.published(name)
    assert fit.name == name
    assert len(fit.source) > 20
    # "unknown": of a layer that is not modelled here.
    assert fit.contract.model in {*ecfit.models(), "unknown"}
