"""`directional_albedo`: shapes, views and the mistakes that it refuses. (Values: tests/quadrature.)"""

import numpy as np
import pytest

import ecfit
from ecfit.errors import EcfitError


def lambertian(**coordinates):
    return ecfit.directional_albedo("lambertian", level=0, **coordinates)


@pytest.mark.parametrize(
    ("mu", "rho", "shape"),
    [
        (0.5, 0.5, ()),
        (np.zeros(3), 0.5, (3,)),
        (np.zeros((2, 1)), np.zeros(3), (2, 3)),
        (np.zeros(0), 0.5, (0,)),
        (1, 1, ()),
    ],
)
def test_results_have_the_broadcast_shape(mu, rho, shape):
    e = lambertian(mu=mu, rho=rho)
    assert e.shape == shape
    assert e.dtype == np.float64


def test_long_inputs_are_batched_without_a_seam():
    rho = np.linspace(0.0, 1.0, 1201)
    np.testing.assert_allclose(lambertian(mu=0.3, rho=rho), rho, atol=1e-8)


def test_r_and_alpha_name_the_same_roughness():
    model = ecfit.model("conductor")
    by_r, by_alpha = (
        float(e)
        for e in (
            ecfit.directional_albedo(model, mu=0.5, r=0.5, level=0),
            ecfit.directional_albedo(model, mu=0.5, alpha=0.25, level=0),
        )
    )
    assert by_r == pytest.approx(by_alpha, rel=1e-15)


def test_parameters_not_given_keep_the_models_values():
    model = ecfit.model("conductor", alpha=0.6)
    implied = float(ecfit.directional_albedo(model, mu=0.5, level=0))
    given = float(ecfit.directional_albedo("conductor", mu=0.5, alpha=0.6, level=0))
    assert implied == given


@pytest.mark.parametrize(
    ("coordinates", "message"),
    [
        ({"alpha": 0.5}, "needs the coordinate mu"),
        ({"mu": 0.5, "alpha": 0.5, "r": 0.7}, "'alpha' given more than once"),
        ({"mu": 0.5, "F0": 0.5}, "'F0' has no effect with .*fresnel = unit"),
        ({"mu": 0.5, "roughness": 0.5}, "no coordinate 'roughness'"),
        ({"mu": 0.5, "level": 99}, "level must be in 0..4"),
        ({"mu": 0.5, "level": -1}, "level must be in 0..4"),
        ({"mu": 0.5, "lobe": "both"}, "unknown lobe"),
        ({"mu": 0.5, "transport": "both"}, "unknown transport"),
    ],
)
def test_mistakes_are_refused(coordinates, message):
    with pytest.raises(EcfitError, match=message):
        ecfit.directional_albedo("conductor", **coordinates)
