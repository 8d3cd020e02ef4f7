"""The lobe as a quantity: coordinates of its own, models with and without an error of f."""

import numpy as np
import pytest

import ecfit
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.quantities import quantity

MU, PHI = np.array([0.1, 0.6, 1.0]), np.array([-1.0, 0.2, 1.0])
AXES = {"alpha": [0.1, 0.7], "mu": MU, "mu_i": MU, "cos_phi": PHI}


def test_a_formula_has_no_error_but_rounding():
    axes = {"rho": [0.2, 0.9], "mu": MU, "mu_i": MU, "cos_phi": 3}
    table = ecfit.tabulate("lambertian", axes, quantity="brdf", quantity_options={"cosine": 1})
    expected = np.array([0.2, 0.9])[:, None, None, None] * MU[:, None] / np.pi
    np.testing.assert_allclose(table.values, np.broadcast_to(expected, table.values.shape), rtol=1e-14)
    assert table.errors.max() < 1e-12
    np.testing.assert_array_equal(table.axes[3].nodes, [-1.0, 0.0, 1.0])  # the coordinate's own range


def test_directions_are_those_of_the_coordinates():
    """A conductor at wi = mirrored wo: F D G2 / (4 mu^2) with h along the normal."""
    table = ecfit.tabulate("conductor", AXES, quantity="brdf")
    alpha, mu = np.array([0.1, 0.7])[:, None], MU
    g1 = 2.0 * mu / (mu + np.sqrt(alpha**2 + (1.0 - alpha**2) * mu * mu))
    expected = g1 * g1 / (4.0 * np.pi * alpha**2 * mu * mu)
    np.testing.assert_allclose(np.einsum("abb->ab", table.values[:, :, :, 0]), expected, rtol=1e-10)


def test_an_integral_is_refined_to_the_tolerance():
    table = ecfit.tabulate("microfacet-diffuse", AXES, quantity="brdf", tolerance=1e-3)
    assert np.all(table.status == 0)
    assert 0.0 < table.errors.max() <= 1e-3
    np.testing.assert_allclose(table.values, table.values.transpose(0, 2, 1, 3), atol=2e-4)


def test_what_cannot_be_asked_for():
    with pytest.raises(EcfitError, match="cosine must be 0"):
        quantity("brdf", cosine=2)
    with pytest.raises(EcfitError, match="of reflection"):
        quantity("brdf", "transmission")
    with pytest.raises(EcfitError, match="needs the axis 'mu_i'"):
        ecfit.tabulate("lambertian", {"mu": 3, "cos_phi": 3}, quantity="brdf")
    axes = {"mu": 3, "mu_i": 3, "cos_phi": Axis.given("cos_phi", [-2.0, 1.0])}
    with pytest.raises(EcfitError, match="outside the model's domain cos_phi"):
        ecfit.tabulate("lambertian", axes, quantity="brdf")
