"""Approximations: coordinates in any view, gradients, and files that read back exactly."""

import dataclasses
import json

import jax
import numpy as np
import pytest

import ecfit
from ecfit.approximation import published_names


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
        dataclasses.replace(conductor, coefficients=np.full(19, np.nan))


def test_an_unknown_published_fit_lists_the_known_ones():
    assert published_names()
    with pytest.raises(ecfit.EcfitError, match=published_names()[0]):
        ecfit.published("sforza-pelacini-2022-conductor")


@pytest.mark.parametrize("name", published_names())
def test_published_fits_have_a_source_and_a_contract(name: str):
    fit = ecfit.published(name)
    assert fit.name == name
    assert len(fit.source) > 20
    assert fit.contract.model in ecfit.models()
