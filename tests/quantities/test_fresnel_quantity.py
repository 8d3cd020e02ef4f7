"""The Fresnel factor as a quantity."""

import numpy as np
import pytest

import ecfit
from ecfit.errors import EcfitError

MU = np.linspace(0.0, 1.0, 33)


def exact(index: complex) -> np.ndarray:
    """Unpolarised Fresnel in complex arithmetic."""
    root = np.sqrt(index * index - (1.0 - MU * MU))
    s, p = (MU - root) / (MU + root), (index * index * MU - root) / (index * index * MU + root)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


def test_dielectrics_and_metals_are_those_of_complex_arithmetic():
    glass = ecfit.tabulate("dielectric", {"ior": [1.5, 2.5], "mu": MU}, quantity="fresnel")
    np.testing.assert_allclose(glass.values, [exact(1.5), exact(2.5)], atol=1e-14)
    metal = ecfit.model("conductor", fresnel="exact", eta=1.3, k=7.48)
    table = ecfit.tabulate(metal, {"mu": MU}, quantity="fresnel")
    np.testing.assert_allclose(table.values, exact(1.3 + 7.48j), atol=1e-14)
    assert table.contract.parameters == {"eta": 1.3, "k": 7.48}


def test_it_has_no_roughness_and_needs_a_factor():
    with pytest.raises(EcfitError, match="no effect on this quantity"):
        ecfit.tabulate("dielectric", {"alpha": 3, "mu": 3}, quantity="fresnel")
    with pytest.raises(EcfitError, match="no Fresnel factor"):
        ecfit.tabulate("lambertian", {"mu": 3}, quantity="fresnel")
