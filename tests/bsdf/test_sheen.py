"""Sheen lobes: a closed form at b = 0, and the shape of their albedos."""

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.bsdf import AshikhminSheen, ImageworksSheen


def test_without_width_the_albedo_has_a_closed_form():
    """(1 / 2) integral of l / (l + v - l v) dl = (1 / a + v log(v) / a^2) / 2, a = 1 - v."""
    v = np.array([0.1, 0.5, 0.9])
    a = 1.0 - v
    measure = AshikhminSheen(b=0.0).measure()
    found = jax.jit(jax.vmap(lambda mu: measure.albedo(mu, 4, "all").value))(jnp.asarray(v))
    np.testing.assert_allclose(found, 0.5 * (1.0 / a + v * np.log(v) / a**2), atol=1e-9)


@pytest.mark.parametrize("model", [AshikhminSheen(b=0.4), ImageworksSheen(r=0.4)])
def test_values_are_those_of_the_formulas_in_angles(model):
    wo, wi = np.array([0.6, 0.0, 0.8]), np.array([-0.3, 0.5, np.sqrt(1.0 - 0.34)])
    h = (wo + wi) / np.linalg.norm(wo + wi)
    theta = np.arccos(h[2])
    if isinstance(model, AshikhminSheen):
        cot2 = 1.0 / np.tan(theta) ** 2
        d = (1.0 + 4.0 * np.exp(-cot2 / 0.16) / np.sin(theta) ** 4) / (np.pi * (1.0 + 4.0 * 0.16))
    else:
        d = (2.0 + 2.5) * np.sin(theta) ** 2.5 / (2.0 * np.pi)
    expected = d / (4.0 * (wo[2] + wi[2] - wo[2] * wi[2]))
    assert float(model.f(jnp.asarray(wo), jnp.asarray(wi))) == pytest.approx(expected, rel=1e-12)
    assert float(model.f(jnp.asarray(wo), -jnp.asarray(wi))) == 0.0


def test_a_narrow_sheen_has_finite_slopes():
    wo = jnp.asarray([0.0, 0.0, 1.0])
    slope = jax.grad(lambda b: AshikhminSheen(b=b).f(wo, wo))(0.0)
    assert np.isfinite(float(slope))
