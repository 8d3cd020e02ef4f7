"""Zonal moments of the lobe (1 - E) mu, against closed forms and an independent integration."""

import math

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, Conductor, Lambertian
from ecfit.errors import EcfitError
from ecfit.quantities import AverageAlbedo, ZonalMoment, quantity


class Square(BSDF):
    """E(mu) = mu^2: no kink, and no constant."""

    reciprocal = False

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, wo[2] ** 2, 0.0) / jnp.pi


def moment(model, degree, level=1):
    found = jax.jit(lambda: ZonalMoment(degree=degree).estimate(model, jnp.asarray(1.0), level))()
    return float(found.value), float(found.error)


# 2 pi Y_l0's factor sqrt((2 l + 1) / (4 pi)) x the integral of P_l(mu) (1 - mu^2) mu over [0, 1], by hand.
@pytest.mark.parametrize(
    ("degree", "integral"), [(0, 1 / 4), (1, 1 / 3 - 1 / 5), (2, 1.5 * (1 / 4 - 1 / 6) - 0.5 / 4), (3, 0.0)]
)
def test_moments_of_a_polynomial_albedo_are_exact(degree, integral):
    if degree == 3:  # P_3 = (5 mu^3 - 3 mu) / 2
        integral = 2.5 * (1 / 5 - 1 / 7) - 1.5 * (1 / 3 - 1 / 5)
    expected = 2.0 * math.pi * math.sqrt((2 * degree + 1) / (4.0 * math.pi)) * integral
    value, error = moment(Square(), degree)
    assert value == pytest.approx(expected, abs=1e-12)
    assert abs(value - expected) <= error + 1e-13


@pytest.mark.parametrize("degree", [7, 20, 32])
def test_high_degrees_are_integrated_exactly_too(degree):
    """A black surface's lobe is the clamped cosine: its moments are known (Ramamoorthi & Hanrahan 2001)."""
    value, error = moment(Lambertian(rho=jnp.asarray(0.0)), degree)
    if degree % 2:
        expected = 0.0
    else:
        half = degree // 2
        expected = 2.0 * math.pi * math.sqrt((2 * degree + 1) / (4.0 * math.pi))
        expected *= (-1) ** (half - 1) / ((degree + 2) * (degree - 1))
        expected *= math.factorial(degree) / (2**degree * math.factorial(half) ** 2)
    assert value == pytest.approx(expected, abs=1e-12)
    assert abs(value - expected) <= error + 1e-13


ALPHA = np.array([0.05, 0.2, 0.5, 1.0])


def along_alpha(rule, level=2):
    model = Conductor()
    found = jax.jit(
        jax.vmap(lambda a: rule.estimate(model.with_parameters({"alpha": a}), jnp.asarray(1.0), level))
    )(jnp.asarray(ALPHA))
    return np.asarray(found.value), np.asarray(found.error)


def test_moments_of_the_conductor_agree_with_panels_over_the_albedo(panels):
    mu, weight = panels([0.0, 1.0], 9, 8)
    lost = 1.0 - np.asarray(ecfit.directional_albedo("conductor", mu=mu, alpha=ALPHA[:, None], level=2))
    expected = 2.0 * math.pi * math.sqrt(5.0 / (4.0 * math.pi)) * (lost * (1.5 * mu**2 - 0.5) * mu) @ weight
    value, estimate = along_alpha(ZonalMoment(degree=2))
    error = np.abs(value - expected)
    assert np.all(error <= estimate + 1e-10)
    assert error.max() < 1e-7
    assert value[0] < -0.002  # of a lobe at grazing
    assert value[-1] > 0.3  # of one about the normal


def test_the_first_moment_is_the_average_albedo():
    zeroth, average = along_alpha(ZonalMoment(), 0)[0], along_alpha(AverageAlbedo(), 0)[0]
    np.testing.assert_allclose(zeroth, 0.5 * math.sqrt(math.pi) * (1.0 - average), rtol=0.0, atol=1e-13)


def test_tables_say_their_degree():
    table = ecfit.tabulate(
        Lambertian(),
        {"rho": [0.0, 1.0]},
        quantity="zonal-moment",
        quantity_options={"degree": 1},
        tolerance=1e-4,
    )
    assert table.contract.quantity_options == {"degree": 1}
    # The clamped cosine's, and nothing.
    np.testing.assert_allclose(table.values, [math.sqrt(math.pi / 3.0), 0.0], atol=1e-11)


def test_only_the_first_moment_is_known_to_lie_in_the_unit_interval():
    model = Conductor()
    assert ZonalMoment(degree=0).bounded(model)
    assert not ZonalMoment(degree=1).bounded(model)


@pytest.mark.parametrize("degree", [-1, 33, 1.0, True])
def test_other_degrees_are_refused(degree):
    with pytest.raises(EcfitError, match="degree must be an integer in 0..32"):
        quantity("zonal-moment", degree=degree)


@pytest.fixture(scope="module")
def lost(panels):
    """alpha, and of each degree the moment of separable GGX by quadrature over its albedo."""
    alpha = np.linspace(0.02, 1.0, 20)
    mu, weight = panels([0.0, 1.0], 6, 6)
    lost = 1.0 - np.asarray(ecfit.directional_albedo("conductor", mu=mu, alpha=alpha[:, None]))
    y = [np.polynomial.legendre.Legendre.basis(n)(mu) * math.sqrt((2 * n + 1) * math.pi) for n in range(3)]
    return alpha, [(lost * p * mu) @ weight for p in y]


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_published_ggx_moments_are_near_the_integral(degree, lost):
    """Of alpha with separable masking; as a function of r they are off by 0.06 and more."""
    published = ecfit.published(f"mayaux-2018-ggx-zonal-{degree}")
    assert published.contract.quantity_options == {"degree": degree}
    assert published.contract.options["masking"] == "separable"
    alpha, moments = lost
    error = np.abs(np.asarray(published(alpha=alpha)) - moments[degree])
    assert 1e-4 < error.mean() < (0.002, 0.003, 0.005)[degree]
    assert np.abs(np.asarray(published(alpha=np.sqrt(alpha))) - moments[degree]).mean() > 0.05


# Exponents of alpha in numerator and denominator, and how many times nearer than the printed one.
RATIONALS = [
    ([[2]], [[0], [1], [3]], 4.0),
    ([[2]], [[0], [1.5], [3]], 15.0),
    ([[1.5], [2]], [[0], [2]], 10.0),
]


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_a_rational_of_as_many_numbers_is_several_times_nearer(degree, lost):
    """Those of configs/msbrdf.toml."""
    alpha, moments = lost
    published = ecfit.published(f"mayaux-2018-ggx-zonal-{degree}")
    numerator, denominator, times = RATIONALS[degree]
    form = ecfit.Structured("ratio", ["alpha"], [numerator], denominator)
    table = ecfit.Table.from_array(moments[degree], {"alpha": alpha}, published.contract)
    fit = ecfit.fit(table, form)
    error = np.abs(np.asarray(published(alpha=alpha)) - moments[degree])
    assert fit.status == "converged"
    assert len(fit.coefficients) == 3
    assert fit.mae < error.mean() / times
    assert fit.max_error < error.max() / times


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_published_oren_nayar_moments_are_of_the_angle_over_a_right_angle(degree, panels):
    """sigma = pi a / 2 of the qualitative model; with sigma = a they are off by 0.04 and more."""
    mu, weight = panels([0.0, 1.0], 8, 8)
    y = np.polynomial.legendre.Legendre.basis(degree)(mu) * math.sqrt((2 * degree + 1) * math.pi)
    sigma = np.linspace(0.05, 1.57, 20)
    lost = [1.0 - np.asarray(ecfit.model("qon", sigma=s).exact_albedo(mu)) for s in sigma]
    moments = np.array([(e * y * mu) @ weight for e in lost])
    published = ecfit.published(f"mayaux-2018-oren-nayar-zonal-{degree}")
    error = np.abs(np.asarray(published(sigma=sigma)) - moments)
    assert 5e-4 < error.mean() < 0.003
    # Read as sigma = a, its argument at that sigma is pi / 2 times as large.
    other = sigma[sigma <= 1.0]
    wrong = np.asarray(published(sigma=other * math.pi / 2.0)) - moments[: other.size]
    assert np.abs(wrong).mean() > 0.03
