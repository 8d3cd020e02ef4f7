"""Distributions of normals: normalisation, Smith's definition of masking, and the slope rule."""

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDFS

ALPHAS = (0.02, 0.1, 0.4, 1.0)
HALF_PI = 0.5 * np.pi

both = pytest.mark.parametrize("name", NDFS)
every_alpha = pytest.mark.parametrize("alpha", ALPHAS)


@both
@every_alpha
def test_projected_area_of_the_microsurface_is_one(name, alpha, panels):
    theta, weight = panels([0.0, HALF_PI], 12, 24)
    d = np.asarray(NDFS[name].D(jnp.cos(jnp.asarray(theta)), jnp.asarray(alpha)))
    assert 2.0 * np.pi * weight @ (d * np.cos(theta) * np.sin(theta)) == pytest.approx(1.0, abs=1e-12)


@both
@every_alpha
def test_density_at_the_normal_is_one_over_pi_alpha_squared(name, alpha):
    d = NDFS[name].D(jnp.asarray(1.0), jnp.asarray(alpha))
    assert float(d) == pytest.approx(1.0 / (np.pi * alpha**2), rel=1e-14)


@both
@every_alpha
@pytest.mark.parametrize("mu", [0.01, 0.1, 0.5, 0.9, 1.0])
def test_masking_keeps_the_projected_area_seen_by_wo(name, alpha, mu, panels):
    """G1(wo) x integral of D(h) <wo, h>+ = mu (Heitz 2014, eq. 14 and 16), with mu / G1 = mu + mu Lambda."""
    theta_o = np.arccos(mu)
    # The integral over the azimuth is closed but has a kink where all normals of a theta begin to face wo.
    theta, weight = panels(np.unique([0.0, HALF_PI - theta_o, HALF_PI]), 24, 20)
    a, b = mu * np.cos(theta), np.sin(theta_o) * np.sin(theta)
    phi = np.arccos(np.clip(-a / np.maximum(b, 1e-300), -1.0, 1.0))
    facing = 2.0 * (a * phi + b * np.sin(phi))
    d = np.asarray(NDFS[name].D(jnp.cos(jnp.asarray(theta)), jnp.asarray(alpha)))
    seen = weight @ (d * facing * np.sin(theta))
    expected = mu + float(NDFS[name].mu_lambda(jnp.asarray(mu), jnp.asarray(alpha)))
    assert seen == pytest.approx(expected, abs=1e-12)


@both
@every_alpha
def test_mu_lambda_agrees_with_the_textbook_lambda(name, alpha, reference_lambda):
    mu = np.linspace(0.01, 1.0, 40)
    ours = NDFS[name].mu_lambda(jnp.asarray(mu), jnp.asarray(alpha))
    np.testing.assert_allclose(ours, mu * reference_lambda(name, mu, alpha), atol=1e-15, rtol=1e-12)


@pytest.mark.parametrize(("name", "slope"), [("ggx", 0.5), ("beckmann", 0.5 / np.sqrt(np.pi))])
@pytest.mark.parametrize("alpha", [0.0, 1e-6, 0.3, 1.0])
def test_mu_lambda_is_proportional_to_alpha_at_grazing(name, slope, alpha):
    value = NDFS[name].mu_lambda(jnp.asarray(0.0), jnp.asarray(alpha))
    assert float(value) == pytest.approx(slope * alpha, rel=1e-14)


@both
def test_mu_lambda_is_finite_and_not_negative_down_to_the_corners(name):
    # 1e-100 is what the half-vector rule adds to mu.
    ends = np.array([0.0, 1e-100, 1e-30, 1e-8, 1e-3, 0.5, 1.0])
    mu, alpha = (jnp.asarray(v.ravel()) for v in np.meshgrid(ends, ends))
    value = np.asarray(NDFS[name].mu_lambda(mu, alpha))
    assert np.all(np.isfinite(value))
    assert value.min() >= -1e-17  # rounding
    # Smooth surfaces mask nothing.
    assert np.all(value[np.asarray(alpha) == 0.0] == 0.0)


@both
def test_gradients_of_mu_lambda_are_finite_down_to_the_corners(name):
    ends = np.array([0.0, 1e-30, 1e-8, 1e-3, 0.5, 1.0])
    mu, alpha = (jnp.asarray(v.ravel()) for v in np.meshgrid(ends, ends))
    gradient = jax.jit(jax.vmap(jax.grad(NDFS[name].mu_lambda, (0, 1))))(mu, alpha)
    assert np.all(np.isfinite(np.asarray(gradient)))


@both
@pytest.mark.parametrize(("mu", "alpha"), [(0.3, 0.2), (0.05, 0.8), (0.9, 0.6)])
def test_gradients_of_mu_lambda_agree_with_differences(name, mu, alpha):
    @jax.jit
    def value(m, a):
        return NDFS[name].mu_lambda(m, a)

    step = 1e-6
    by_mu, by_alpha = jax.jit(jax.grad(value, (0, 1)))(mu, alpha)
    assert float(by_mu) == pytest.approx(
        float(value(mu + step, alpha) - value(mu - step, alpha)) / (2 * step), abs=1e-8
    )
    assert float(by_alpha) == pytest.approx(
        float(value(mu, alpha + step) - value(mu, alpha - step)) / (2 * step), abs=1e-8
    )


@both
@pytest.mark.parametrize("alpha", [0.03, 1.0])
@pytest.mark.parametrize(("num", "den"), [(0.15, 0.5), (2.0, 1.0), (9.0, 1.0), (1.0, 0.0)])
def test_charts_integrate_density_times_a_smooth_function(name, alpha, num, den, panels):
    """One chart of T = tan(theta) / alpha serves every alpha and every upper end, infinity among them."""

    def g(t):
        return 1.0 / (1.0 + t * t) + t * t / (4.0 + t * t) ** 2

    end = np.arctan(alpha * num / den) if den else HALF_PI
    theta, weight = panels([0.0, end], 14, 24)
    d = np.asarray(NDFS[name].D(jnp.cos(jnp.asarray(theta)), jnp.asarray(alpha)))
    expected = weight @ (g(np.tan(theta) / alpha) * d * np.cos(theta) * np.sin(theta))
    u, w = panels([0.0, 1.0], 0, 64)
    ndf = NDFS[name]
    top = ndf.chart(jnp.asarray(num), jnp.asarray(den))
    n, c, density = (np.asarray(v) for v in ndf.nodes(top * u))
    assert w @ (g(n / c) * c * density) * float(top) == pytest.approx(expected, abs=1e-13)
