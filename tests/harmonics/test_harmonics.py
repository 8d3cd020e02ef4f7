"""Spherical harmonics and the lobe's irradiance, against quadrature over the sphere in NumPy."""

import math

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax
from ecfit.errors import EcfitError
from ecfit.harmonics import (
    legendre,
    lobe_irradiance,
    multiple_scattering_radiance,
    rotated_zonal,
    spherical_harmonics,
    zonal_harmonic,
)
from ecfit.quantities import ZonalMoment


def sphere(count: int, mu_edges=(-1.0, 1.0)):
    """Directions and weights: Gauss-Legendre in z on panels, equidistant in azimuth."""
    x, w = np.polynomial.legendre.leggauss(count)
    low, width = np.asarray(mu_edges)[:-1, None], np.diff(mu_edges)[:, None]
    z, wz = (low + width * 0.5 * (x + 1.0)).ravel(), (width * 0.5 * w).ravel()
    phi = 2.0 * np.pi * np.arange(2 * count) / (2 * count)
    s = np.sqrt(1.0 - z * z)
    d = np.stack(np.broadcast_arrays(s[:, None] * np.cos(phi), s[:, None] * np.sin(phi), z[:, None]), axis=-1)
    return d.reshape(-1, 3), np.repeat(wz * np.pi / count, 2 * count)


def frame(normal):
    """Rows t, b, n."""
    helper = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.5 else np.array([0.0, 1.0, 0.0])
    t = np.cross(helper, normal)
    t /= np.linalg.norm(t)
    return np.stack([t, np.cross(normal, t), normal])


def test_the_nine_harmonics_are_orthonormal():
    d, w = sphere(8)
    y = np.asarray(spherical_harmonics(d))
    np.testing.assert_allclose((y * w[:, None]).T @ y, np.eye(9), atol=1e-14)


def test_they_are_the_harmonics_of_their_degrees():
    """Addition theorem (Unsold): sums over m of Y_lm(a) Y_lm(b) = (2 l + 1) / (4 pi) P_l(a.b)."""
    d, _ = sphere(4)
    y = np.asarray(spherical_harmonics(d))
    for degree, part in enumerate((slice(0, 1), slice(1, 4), slice(4, 9))):
        expected = (2 * degree + 1) / (4.0 * math.pi) * np.asarray(legendre(degree, d @ d.T))
        np.testing.assert_allclose(y[:, part] @ y[:, part].T, expected, atol=1e-14)


def test_zonal_harmonics_are_those_of_order_zero():
    d, _ = sphere(5)
    y = np.asarray(spherical_harmonics(d))
    for degree, index in enumerate((0, 2, 6)):
        np.testing.assert_allclose(np.asarray(zonal_harmonic(degree, d[:, 2])), y[:, index], atol=1e-15)


@pytest.mark.parametrize("degree", [0, 1, 5, 12])
def test_legendre_polynomials_agree_with_numpy(degree):
    x = np.linspace(-1.0, 1.0, 31)
    expected = np.polynomial.legendre.Legendre.basis(degree)(x)
    np.testing.assert_allclose(np.asarray(legendre(degree, x)), expected, atol=1e-13)


def test_a_turned_lobe_has_the_coefficients_of_the_turned_lobe():
    """A lobe a + b c + d c^2, c = w.n, projected on the harmonics by quadrature."""
    normal = np.array([0.48, -0.6, 0.64])
    d, w = sphere(12)
    projected = (np.asarray(spherical_harmonics(d)) * w[:, None]).T @ (0.3 + 0.5 * (d @ normal) ** 2)
    z, wz = np.polynomial.legendre.leggauss(12)
    about_z = 0.3 + 0.5 * z**2
    moments = [2.0 * math.pi * wz @ (np.asarray(zonal_harmonic(degree, z)) * about_z) for degree in range(3)]
    np.testing.assert_allclose(np.asarray(rotated_zonal(moments, normal)), projected, atol=1e-13)


ENVIRONMENT = np.array([1.0, 0.4, -0.3, 0.8, 0.25, -0.6, 0.7, 0.15, -0.45])


def brute_force(albedo, normal):
    """The environment's irradiance through 1 - E, over the hemisphere of the normal."""
    # The panels halve towards grazing, where E turns.
    local, w = sphere(16, (0.0, 1 / 64, 1 / 16, 1 / 4, 1.0))
    mu, where = np.unique(local[:, 2], return_inverse=True)
    radiance = np.asarray(spherical_harmonics(local @ frame(np.array(normal)))) @ ENVIRONMENT
    return w @ (radiance * (1.0 - np.asarray(albedo(mu))[where]) * local[:, 2])


def moments_of(albedo):
    """E_0, E_1, E_2 by quadrature over mu."""
    x, w = np.polynomial.legendre.leggauss(200)
    mu = (0.5 * (x + 1.0)) ** 2
    weight = w * np.sqrt(mu) * (1.0 - np.asarray(albedo(mu))) * mu
    return np.array([2.0 * math.pi * np.asarray(zonal_harmonic(n, mu)) @ weight for n in range(3)])


NORMALS = [(0.0, 0.0, 1.0), (0.48, -0.6, 0.64), (-0.6, 0.0, -0.8)]


@pytest.mark.parametrize("normal", NORMALS)
def test_irradiance_agrees_with_integration_over_the_hemisphere(normal):
    def albedo(mu):
        return 1.0 / (1.0 + 0.6 / (0.3 + mu))

    expected = brute_force(albedo, normal)
    found = float(lobe_irradiance(ENVIRONMENT, moments_of(albedo), normal))
    assert found == pytest.approx(expected, abs=1e-9)
    assert abs(expected) > 0.01


@pytest.mark.slow
def test_irradiance_of_the_conductor_agrees_with_integration_over_the_hemisphere():
    model = ecfit.model("conductor", alpha=0.7)
    rules = [ZonalMoment(degree=degree) for degree in range(3)]
    moments = [float(jax.jit(lambda r=r: r.estimate(model, 1.0, 3).value)()) for r in rules]
    for normal in NORMALS:
        expected = brute_force(lambda mu: ecfit.directional_albedo(model, mu=mu, level=3), normal)
        assert float(lobe_irradiance(ENVIRONMENT, moments, normal)) == pytest.approx(expected, abs=1e-9)


def test_a_white_surface_in_a_uniform_environment_adds_what_it_lacks():
    moments = moments_of(lambda mu: mu**2)  # E_avg = 1/2
    uniform = np.array([math.sqrt(4.0 * math.pi), *[0.0] * 8])
    added = multiple_scattering_radiance(uniform, moments, [0.6, 0.0, 0.8], 0.4, 0.5)
    assert float(added) == pytest.approx(0.6, abs=1e-13)


def test_other_shapes_are_refused():
    with pytest.raises(EcfitError, match=r"environment must have shape \(..., 9\), got \(4,\)"):
        lobe_irradiance([1.0] * 4, [1.0, 1.0, 1.0], [0.0, 0.0, 1.0])
    with pytest.raises(EcfitError, match=r"moments must have shape \(..., 3\), got \(2,\)"):
        lobe_irradiance([1.0] * 9, [1.0, 1.0], [0.0, 0.0, 1.0])
