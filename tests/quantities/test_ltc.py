"""The transformed cosine nearest to the lobe of lost energy, against lobes that are one, and NumPy."""

import math

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, Conductor, Lambertian
from ecfit.ltc import stretched_cosine
from ecfit.quantities import LtcScale

SCALE = 1.7


class Stretched(BSDF):
    """1 - E(mu) = 0.2 pi D(mu) / mu: the lobe is a transformed cosine itself."""

    scale: jax.Array = ecfit.parameter(SCALE, 0.5, 4.0, "of the lobe")
    reciprocal = False

    def f(self, wo, wi):
        square = self.scale**2
        mu = wo[2]
        lost = 0.2 * square / (1.0 - mu * mu + square * mu * mu) ** 2
        return jnp.where(wi[2] > 0.0, 1.0 - lost, 0.0) / jnp.pi


@pytest.mark.parametrize("scale", [0.8, 1.0, 2.5])
def test_a_lobe_that_is_a_transformed_cosine_is_found(scale):
    model = Stretched(scale=scale)
    found = jax.jit(lambda: LtcScale().estimate(model, jnp.asarray(1.0), 1))()
    assert float(found.value) == pytest.approx(scale, abs=1e-8)
    assert abs(float(found.value) - scale) <= float(found.error) + 1e-10


def test_its_derivative_is_that_of_the_lobe():
    slope = jax.jit(jax.grad(lambda a: LtcScale().estimate(Stretched(scale=a), jnp.asarray(1.0), 0).value))
    assert float(slope(SCALE)) == pytest.approx(1.0, abs=1e-4)


def test_of_the_conductor_it_is_the_least_square():
    alpha = 0.7
    x, w = np.polynomial.legendre.leggauss(40)
    mu, weight = (0.5 * (x + 1.0)) ** 2, 0.5 * w * (x + 1.0)
    model = Conductor(alpha=alpha)
    lobe = (1.0 - np.asarray(ecfit.directional_albedo(model, mu=mu))) * mu
    lobe /= 2.0 * math.pi * weight @ lobe

    def distance(scale):
        return weight @ (np.asarray(stretched_cosine(mu, scale)) - lobe) ** 2

    found = jax.jit(lambda: LtcScale().estimate(model, jnp.asarray(1.0), 2))()
    scale, step = float(found.value), 1e-4
    here, left, right = distance(scale), distance(scale - step), distance(scale + step)
    # The parabola through three points has its top within the estimate of the place.
    top = scale + 0.5 * step * (left - right) / (left - 2.0 * here + right)
    assert top == pytest.approx(scale, abs=1e-6)
    assert float(found.error) < 1e-6
    assert distance(0.5 * scale) > here < distance(2.0 * scale)


def test_where_nothing_is_lost_there_is_no_lobe():
    white = Lambertian(rho=jnp.asarray(1.0))
    found = jax.jit(lambda: LtcScale().estimate(white, jnp.asarray(1.0), 0))()
    assert math.isnan(float(found.value))
