"""The albedo rule of smooth isotropic lobes."""

import numpy as np
import pytest

from ecfit._jax import jnp
from ecfit.quadrature import Estimate, PairedHemisphere


def lobe(value, error=0.0):
    def at(mu_o, mu_i, cos_phi, level):
        found = value(mu_o, mu_i, cos_phi)
        return Estimate(found, jnp.full_like(found, error))

    return PairedHemisphere(at, (1, 1, 1, 1))


MU = jnp.asarray(0.3)


def test_a_polynomial_is_integrated_to_rounding():
    found = lobe(lambda o, i, c: (o + i * i + i * c * c) / jnp.pi).albedo(MU, 2, "all")
    # 2 x integral of (0.3 + i^2 + i / 2) i di
    assert float(found.value) == pytest.approx(0.3 + 0.5 + 1.0 / 3.0, rel=1e-12)
    assert float(found.error) < 1e-7


def test_the_errors_of_values_are_part_of_the_estimate():
    found = lobe(lambda o, i, c: 0.0 * i * c + 1.0 / jnp.pi, 1e-3).albedo(MU, 1, "reflection")
    assert float(found.error) == pytest.approx(np.pi * 1e-3, rel=1e-6)


def test_a_jump_is_in_the_estimate():
    found = lobe(lambda o, i, c: jnp.where(i > 0.37, 1.0, 0.0) + 0.0 * c).albedo(MU, 3, "all")
    error = abs(float(found.value) - np.pi * (1.0 - 0.37**2))
    assert 1e-5 < error < float(found.error)


def test_nothing_is_transmitted():
    found = lobe(lambda o, i, c: i * c).albedo(MU, 0, "transmission")
    assert (float(found.value), float(found.error)) == (0.0, 0.0)
