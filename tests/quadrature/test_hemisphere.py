"""The general rule: what it integrates exactly, and that it says where it does not."""

import math
from functools import cache
from typing import ClassVar

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, Conductor
from ecfit.quadrature import Hemisphere, Status


class Coarse(Hemisphere):
    """The first levels only: each costs a compilation, and to be honest is a matter of every level."""

    ORDERS: ClassVar = Hemisphere.ORDERS[:3]


MU = np.array([0.0, 1e-6, 0.05, 0.4, 0.8, 0.999, 1.0])


class Generic(Conductor):
    """The conductor without its half-vector rule."""

    def measure(self) -> Hemisphere:  # pyright: ignore[reportIncompatibleMethodOverride]
        return Coarse(self.f, False)


class Diffuse(BSDF):
    """Reflects 0.3 and transmits 0.5, both Lambertian."""

    transmissive = True

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, 0.3, 0.5) / jnp.pi


class Edge(BSDF):
    """White within 0.7 rad of the normal and black beyond: E = sin(0.7)^2."""

    def f(self, wo, wi):
        return jnp.where(wi[2] > math.cos(0.7), 1.0, 0.0) / jnp.pi

    def measure(self):
        return Coarse(self.f, False)


class ToldEdge(Edge):
    """The same, which tells of its edge."""

    def edges(self, mu):
        return jnp.asarray([math.cos(0.7)])

    def measure(self):
        return Coarse(self.f, False, self.edges)


class TwoSided(BSDF):
    """Reflects within 0.7 rad of the normal, and transmits within 0.4 rad of it on the other side."""

    transmissive = True

    def f(self, wo, wi):
        inside = jnp.where(wi[2] > 0.0, wi[2] > math.cos(0.7), wi[2] < -math.cos(0.4))
        return jnp.where(inside, 1.0, 0.0) / jnp.pi

    def edges(self, mu):
        # The third lies outside [-1, 1] and counts as none.
        return jnp.asarray([math.cos(0.7), -math.cos(0.4), 2.0])

    def measure(self):
        return Coarse(self.f, True, self.edges)


@cache
def estimates(model_class: type[BSDF], level: int, lobe: str = "all"):
    rule = model_class().measure()
    found = jax.jit(jax.vmap(lambda mu: rule.albedo(mu, level, lobe)))(jnp.asarray(MU))
    return np.asarray(found.value), np.asarray(found.error)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_constant_is_integrated_exactly(level):
    value, error = estimates(Diffuse, level)
    # 8 nodes on up to half the hemisphere leave 1e-9 of the sine and cosine.
    np.testing.assert_allclose(value, 0.8, atol=1e-8 if level == 0 else 1e-12)
    assert np.all(np.abs(value - 0.8) <= error + 1e-14)
    assert error.max() < 1e-3


def test_lobes_are_the_two_sides():
    reflected, transmitted = (estimates(Diffuse, 1, lobe)[0] for lobe in ("reflection", "transmission"))
    np.testing.assert_allclose(reflected, 0.3, atol=1e-12)
    np.testing.assert_allclose(transmitted, 0.5, atol=1e-12)


def test_an_opaque_model_is_not_asked_about_the_other_side():
    asked: list[str] = []

    def f(wo, wi):
        asked.append("once a side")
        return jnp.where(wi[2] > 0.0, 1.0, jnp.nan) / jnp.pi

    rule = Hemisphere(f, transmissive=False)
    both, none = (
        jax.jit(lambda mu, lobe=lobe: rule.albedo(mu, 0, lobe).value)(0.5) for lobe in ("all", "transmission")
    )
    assert float(both) == pytest.approx(1.0, abs=1e-8)
    assert float(none) == 0.0
    # For the nodes, and for the look at a peak between them; a transmissive rule asks twice as often.
    assert len(asked) == 2


@pytest.mark.parametrize("transmissive", [False, True])
def test_stated_node_counts_are_those_evaluated(transmissive):
    rule = Hemisphere(lambda wo, wi: wi[2], transmissive)
    for level, expected in enumerate(rule.levels):
        shapes = jax.make_jaxpr(lambda mu, level=level: rule.albedo(mu, level, "all").value)(0.5)
        # The integrand is the largest array, once for each side.
        largest = max(math.prod(v.aval.shape) for eqn in shapes.eqns for v in eqn.outvars)
        assert largest in (expected // (2 if transmissive else 1), 3 * expected // (2 if transmissive else 1))


@pytest.mark.parametrize("ndf", ["ggx", "beckmann"])
def test_the_half_vector_rule_agrees_within_both_estimates(ndf):
    """The two share f (one through D and G, one as it is) and nothing of their quadrature."""
    mu, alpha = (jnp.asarray(v.ravel()) for v in np.meshgrid([0.15, 0.6, 0.95], [0.3, 1.0]))

    def both(m, a):
        model = Conductor(ndf=ndf).with_parameters({"alpha": a})
        rules = Hemisphere(model.f, False), model.measure()
        return [rule.albedo(m, 3, "all") for rule in rules]

    general, special = jax.jit(jax.vmap(both))(mu, alpha)
    difference = np.abs(np.asarray(general.value - special.value))
    assert np.all(difference <= np.asarray(general.error + special.error))
    assert difference.max() < 1e-4
    # Away from grazing at alpha = 0.3 the general rule has all but converged.
    assert np.all(np.asarray(general.error)[1:] < 1e-4)


def test_an_edge_does_not_pass_for_converged():
    table = ecfit.tabulate(Edge(), {"mu": [0.1, 0.5, 0.9]}, tolerance=1e-6)
    assert np.all(table.status == Status.TOLERANCE_NOT_MET)
    error = np.abs(table.values - math.sin(0.7) ** 2)
    assert error.max() < 5e-2
    assert np.all(error <= table.errors)
    assert any("tolerance" in line for line in table.describe())


def test_an_edge_that_a_model_tells_of_does_no_harm():
    """On either side of theta_i = theta_o, and on it."""
    mu = [0.0, 0.1, math.cos(0.7), 0.9, 1.0]
    table = ecfit.tabulate(ToldEdge(), {"mu": mu}, tolerance=1e-9)
    assert np.all(table.status == Status.CONVERGED)
    np.testing.assert_allclose(table.values, math.sin(0.7) ** 2, atol=1e-9)


def test_edges_with_negative_cosines_are_those_of_the_other_side():
    value, error = estimates(TwoSided, 2)
    np.testing.assert_allclose(value, math.sin(0.7) ** 2 + math.sin(0.4) ** 2, atol=1e-9)
    assert np.all(error < 1e-6)


def test_the_edges_of_a_model_reach_its_default_measure():
    assert TwoSided.__mro__[1].measure(TwoSided()).edges is not None


def test_a_peak_at_the_mirror_direction_is_found_or_said_to_be_missed():
    """E is 1 within 1e-5 at r = 0.01 and 0.055: an entry may say that it did not converge, not that E is 0.

    The ends of the range of mu are entries of nearly every table.
    """
    axes = {"alpha": [1e-4, 3e-3], "mu": [0.5, 1.0]}
    table = ecfit.tabulate(Generic(ndf="beckmann"), axes, tolerance=1e-4)
    assert np.all((np.abs(table.values - 1.0) <= table.errors + 1e-5) | (table.status != Status.CONVERGED))


def test_grazing_is_the_limit_of_small_mu():
    """Models are defined for wo.z > 0, and the conductor's f is 0 at 0; E is not."""
    mu = jnp.asarray([0.0, 1e-6])
    rule = Generic(alpha=jnp.asarray(1.0)).measure()
    at_zero, nearby = np.asarray(jax.jit(jax.vmap(lambda m: rule.albedo(m, 2, "all").value))(mu))
    assert nearby > 0.5
    assert at_zero == pytest.approx(nearby, abs=1e-4)


def test_gradients_agree_with_differences():
    @jax.jit
    def value(alpha):
        return Generic().with_parameters({"alpha": alpha}).measure().albedo(jnp.asarray(0.6), 2, "all").value

    slope = float(jax.jit(jax.grad(value))(0.5))
    difference = (float(value(0.5 + 1e-5)) - float(value(0.5 - 1e-5))) / 2e-5
    assert slope == pytest.approx(difference, abs=1e-8)


class Sector(BSDF):
    """White towards the viewer, black more than 1 rad of azimuth away from it: E = 1 / pi."""

    def f(self, wo, wi):
        return jnp.where(jnp.abs(jnp.arctan2(wi[1], wi[0])) < 1.0, 1.0, 0.0) / jnp.pi

    def measure(self):
        return Coarse(self.f, False, self.edges, self.azimuths)


class ToldSector(Sector):
    """The same, which tells of its edge."""

    azimuths = (1.0,)


def test_jumps_at_told_azimuths_converge():
    told, untold = (estimates(model, 1)[0] for model in (ToldSector, Sector))
    np.testing.assert_allclose(told, 1.0 / math.pi, atol=1e-12)
    assert np.abs(untold - 1.0 / math.pi).max() > 1e-3
    assert (
        Coarse(lambda o, i: 0.0, False, None, (1.0,)).levels[0]
        == 2 * Coarse(lambda o, i: 0.0, False).levels[0]
    )
