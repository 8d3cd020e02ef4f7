"""The rule over facets that two directions see: closed forms, brute force, and honest estimates."""

from functools import cache

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDFS
from ecfit.quadrature import Estimate, FacetPairs


def fresnel(x, y):
    return (1.0 - (1.0 - x) ** 5) * (1.0 - (1.0 - y) ** 5)


def unit(x, y):
    return jnp.ones_like(x)


def kinked(x, y):
    return jnp.abs(x - 0.6)


WEIGHTS = {"fresnel": fresnel, "unit": unit, "kinked": kinked}


@cache
def rule(level: int, weight: str, ndf: str = "ggx"):
    def one(alpha, mu_o, mu_i, cos_phi):
        return FacetPairs(NDFS[ndf], alpha, WEIGHTS[weight]).integral(mu_o, mu_i, cos_phi, level)

    return jax.jit(jax.vmap(one))


def integral(level: int, weight: str, *point, ndf: str = "ggx") -> Estimate:
    arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(p, dtype=np.float64)) for p in point))
    return Estimate(*map(np.asarray, rule(level, weight, ndf)(*arrays)))


def sample() -> list[np.ndarray]:
    """(alpha, mu_o, mu_i, cos_phi): a half grazing over all magnitudes, and smooth ones."""
    rng = np.random.default_rng(3)
    alpha, mu_o, mu_i, turn = rng.random((4, 96))
    mu_o[:32] = 10.0 ** rng.uniform(-4, -1, 32)
    mu_i[16:48] = 10.0 ** rng.uniform(-4, -1, 32)
    alpha[8:40] = 10.0 ** rng.uniform(-3, 0, 32)
    turn[:8] = [0.0, 1.0, 0.5, 1e-6, 0.0, 1.0, 0.5, 1.0 - 1e-6]
    return [alpha, mu_o, mu_i, np.cos(np.pi * turn)]


def brute_force(alpha, mu_o, mu_i, cos_phi, ndf="ggx", count=1500):
    """Midpoints in a slope's own angle and the azimuth, with nothing of the rule."""
    s_o, s_i = np.sqrt(1.0 - mu_o**2), np.sqrt(1.0 - mu_i**2)
    u = (np.arange(count) + 0.5) / count
    phi = 2.0 * np.pi * u
    if ndf == "ggx":
        slope = np.tan(0.5 * np.pi * u)
        density = np.sin(0.5 * np.pi * u) * np.cos(0.5 * np.pi * u) * 0.5
    else:  # T = 6 u^2
        slope = 6.0 * u * u
        density = 12.0 * u * slope * np.exp(-slope * slope) / np.pi
    t = alpha * slope[:, None]
    x = np.maximum(mu_o + s_o * t * np.cos(phi), 0.0) / np.sqrt(1.0 + t * t)
    y = np.maximum(mu_i + s_i * t * np.cos(phi - np.arccos(cos_phi)), 0.0) / np.sqrt(1.0 + t * t)
    values = x * y * np.sqrt(1.0 + t * t) * fresnel(x, y) * density[:, None]
    return values.mean() * 2.0 * np.pi


def test_a_smooth_surface_has_one_facet():
    _, mu_o, mu_i, cos_phi = sample()
    found = integral(1, "fresnel", 0.0, mu_o, mu_i, cos_phi)
    np.testing.assert_allclose(found.value, mu_o * mu_i * fresnel(mu_o, mu_i), atol=1e-9)


def test_facets_of_a_sphere_in_closed_form():
    """alpha = 1 is D = 1 / pi; two directions in the horizon at the angle g see
    (sin g + (pi - g) cos g) / (3 pi), and the normal with itself 2/3."""
    angle = np.linspace(0.0, np.pi, 9)
    found = integral(3, "unit", 1.0, 0.0, 0.0, np.cos(angle))
    expected = (np.sin(angle) + (np.pi - angle) * np.cos(angle)) / (3.0 * np.pi)
    np.testing.assert_allclose(found.value, expected, atol=1e-9)
    assert integral(3, "unit", 1.0, 1.0, 1.0, 1.0).value[0] == pytest.approx(2.0 / 3.0, abs=1e-10)


@pytest.mark.parametrize("ndf", ["ggx", pytest.param("beckmann", marks=pytest.mark.slow)])
def test_brute_force_agrees(ndf):
    points = [a[::12] for a in sample()]
    found = integral(3, "fresnel", *points, ndf=ndf).value
    expected = [brute_force(*p, ndf=ndf) for p in zip(*points, strict=True)]
    np.testing.assert_allclose(found, expected, atol=2e-7)


def test_levels_converge_and_their_estimates_are_honest():
    finest = integral(3, "fresnel", *sample()).value  # good to 1e-10 here, by the next level
    for level, good in enumerate((1e-3, 1e-5, 1e-7)):
        found = integral(level, "fresnel", *sample())
        error = np.abs(found.value - finest)
        assert error.max() < good
        assert np.all(error <= found.error + 1e-10)


def test_a_kink_that_the_rule_knows_nothing_of_is_in_the_estimate():
    coarse, fine = (integral(level, "kinked", 0.5, 0.7, 0.4, 0.2) for level in (0, 3))
    error = abs(float(coarse.value[0] - fine.value[0]))
    assert error > 1e-7
    assert error < float(coarse.error[0])


def test_directions_may_be_exchanged():
    alpha, mu_o, mu_i, cos_phi = sample()
    there = integral(3, "fresnel", alpha, mu_o, mu_i, cos_phi).value
    back = integral(3, "fresnel", alpha, mu_i, mu_o, cos_phi).value
    np.testing.assert_allclose(there, back, atol=2e-10)
