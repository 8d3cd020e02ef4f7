"""`check_bsdf` finds each planted fault, and passes sound models."""

from typing import ClassVar

import jax
import jax.numpy as jnp
import pytest

import ecfit
from ecfit.quadrature import Hemisphere


class Coarse(Hemisphere):
    """The first levels only: a model that is at fault climbs them all, and each costs a compilation."""

    ORDERS: ClassVar = Hemisphere.ORDERS[:4]


class Sound(ecfit.BSDF):
    """Lambertian, to be spoilt."""

    rho: jax.Array = ecfit.parameter(0.5, 0.0, 1.0, "reflectance")

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, self.rho / jnp.pi, 0.0)

    def measure(self):
        return Coarse(self.f, self.transmissive)


class Negative(Sound):
    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, self.rho * (wi[2] * wo[2] - 0.01), 0.0)


class OneWay(Sound):
    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, self.rho * wi[2] / jnp.pi, 0.0)


class Leaking(Sound):
    def f(self, wo, wi):
        return self.rho / jnp.pi + 0.0 * wi[2]


class Bright(Sound):
    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, 1.2 / jnp.pi + 0.0 * self.rho, 0.0)


class Undefined(Sound):
    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, jnp.sqrt(wi[2] - 0.5) * self.rho, 0.0)


class BadGradient(Sound):
    def f(self, wo, wi):
        # The classic: a root in the branch that is not taken.
        root = jnp.where(wi[2] > 0.5, jnp.sqrt(self.rho * (wi[2] - 0.5)), self.rho / jnp.pi)
        return jnp.where(wi[2] > 0.0, root, 0.0)


class Vector(Sound):
    def f(self, wo, wi):
        return self.rho * wi


class WrongOracle(Sound):
    def exact_albedo(self, mu):
        return 0.9 * self.rho * jnp.ones_like(mu)


@pytest.mark.parametrize("model", ["conductor", "lambertian", Sound])
def test_sound_models_pass(model):
    found = ecfit.check_bsdf(model, samples=100)
    assert found, str(found)
    assert "passed" in str(found)


@pytest.mark.parametrize(
    ("model", "fault"),
    [
        (Negative, "non-negative"),
        (OneWay, "reciprocal"),
        (Leaking, "zero below the horizon"),
        (Bright, "energy <= 1"),
        (Undefined, "finite"),
        (BadGradient, "gradients"),
        (Vector, "runs under jit and vmap"),
        (WrongOracle, "exact albedo"),
    ],
)
def test_a_planted_fault_is_named(model: type[ecfit.BSDF], fault: str):
    found = ecfit.check_bsdf(model, samples=100)
    assert not found
    failed = [f for f in found.findings if not f.passed]
    assert fault in [f.name for f in failed], str(found)
    assert all(f.detail for f in failed)


def test_claims_that_a_model_does_not_make_are_not_held_against_it():
    class Honest(OneWay):
        reciprocal = False

    found = ecfit.check_bsdf(Honest, samples=100)
    assert "reciprocal" not in [f.name for f in found.findings if not f.passed]
