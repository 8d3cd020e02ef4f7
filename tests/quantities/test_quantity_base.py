"""Quantities: lobes, transports and the average albedo."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, Conductor, Lambertian
from ecfit.contract import QUANTITIES
from ecfit.errors import EcfitError
from ecfit.quantities import AverageAlbedo, DirectionalAlbedo, quantity

INDEX = 1.5


class Glass(BSDF):
    """Reflects 0.3; transmits 0.2 per steradian-projected unit as radiance, 0.2 x 1.5^2 as energy."""

    transmissive = True

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, 0.3, 0.2) / jnp.pi

    def relative_ior(self):
        return jnp.asarray(INDEX)


class Linear(BSDF):
    """E(mu) = mu, so that E_avg = 2/3."""

    reciprocal = False

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, wo[2], 0.0) / jnp.pi


@pytest.mark.parametrize(
    ("lobe", "transport", "expected"),
    [
        ("reflection", "energy", 0.3),
        ("reflection", "radiance", 0.3),
        ("transmission", "radiance", 0.2),
        ("transmission", "energy", 0.2 * INDEX**2),
        ("all", "radiance", 0.5),
        ("all", "energy", 0.3 + 0.2 * INDEX**2),
    ],
)
def test_energy_scales_the_transmitted_lobe_by_the_index_squared(lobe, transport, expected):
    e = ecfit.directional_albedo(Glass(), mu=0.4, lobe=lobe, transport=transport, level=1)
    assert float(e) == pytest.approx(expected, rel=1e-11)


def test_an_opaque_model_is_the_same_in_both_transports():
    model = ecfit.model("conductor", alpha=0.5)
    energy, radiance = (
        float(ecfit.directional_albedo(model, mu=0.4, transport=t, level=0)) for t in ("energy", "radiance")
    )
    assert energy == radiance


@pytest.mark.parametrize(
    ("model", "expected"), [(Linear(), 2.0 / 3.0), (Lambertian(rho=jnp.asarray(0.7)), 0.7)]
)
def test_the_average_albedo_of_simple_models_is_exact(model, expected):
    rule = AverageAlbedo()
    found = jax.jit(lambda: rule.estimate(model, jnp.asarray(1.0), 1))()
    assert float(found.value) == pytest.approx(expected, rel=1e-11)
    assert abs(float(found.value) - expected) <= float(found.error) + 1e-14


@pytest.mark.parametrize(
    ("ndf", "masking"),
    [("ggx", "separable"), pytest.param("beckmann", "height-correlated", marks=pytest.mark.slow)],
)
def test_the_average_albedo_is_the_weighted_mean_of_the_directional_one(ndf, masking, panels):
    """Honest and accurate. E(mu) turns within mu ~ r^2: between the nodes of the average's rule."""
    model = ecfit.model("conductor", ndf=ndf, masking=masking)
    r = np.array([0.003, 0.03, 0.04436687, 0.06, 0.12666667, 0.3, 0.6, 1.0])
    table = ecfit.tabulate(model, {"r": r}, quantity="average-albedo", tolerance=1e-6)
    mu, weight = panels([0.0, 1.0], 14, 12)
    e = np.asarray(ecfit.directional_albedo(model, mu=mu, r=r[:, None], level=2))
    error = np.abs(table.values - 2.0 * (e * mu) @ weight)
    assert np.all(error <= table.errors + 1e-8)  # the directional albedo's own error
    assert table.errors.max() <= 1e-6
    # From a mirror to the roughest: the comparison is not of ones with ones.
    assert table.values.max() - table.values.min() > 0.05


def test_quantities_state_as_many_levels_as_the_measure_has():
    model = Conductor()
    levels = model.measure().levels
    assert DirectionalAlbedo().nodes(model) == levels
    average = AverageAlbedo().nodes(model)
    assert len(average) == len(levels)
    assert all(a > n for a, n in zip(average, levels, strict=True))


def test_stated_node_counts_of_the_average_are_those_evaluated():
    """They size the blocks in memory."""
    model = Conductor()
    for level, expected in enumerate(AverageAlbedo().nodes(model)):
        shapes = jax.make_jaxpr(
            lambda level=level: AverageAlbedo().estimate(model, jnp.asarray(1.0), level).value
        )()
        assert max(int(np.prod(v.aval.shape)) for eqn in shapes.eqns for v in eqn.outvars) == expected


def test_every_quantity_of_the_contract_can_be_made():
    for name in QUANTITIES:
        assert quantity(name, "reflection", "radiance").transport == "radiance"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("albedo",), "unknown quantity 'albedo'"),
        (("directional-albedo", "reflected"), "unknown lobe 'reflected'.*did you mean 'reflection'"),
        (("directional-albedo", "all", "power"), "unknown transport 'power'"),
    ],
)
def test_unknown_names_are_refused(arguments, message):
    with pytest.raises(EcfitError, match=message):
        quantity(*arguments)
