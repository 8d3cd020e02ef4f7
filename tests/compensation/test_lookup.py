"""Approximations at a model's own parameters, in the view that they were fitted in."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.bsdf import Conductor
from ecfit.compensation.glossy import Glossy
from ecfit.compensation.lookup import albedo_of, coordinates_of
from ecfit.errors import EcfitError


def test_views_are_resolved():
    """r stands for alpha and F0 for ior; the model knows its own names only."""
    conductor, glossy = (ecfit.published(f"sforza-pellacini-2022-{n}") for n in ("conductor", "glossy"))
    assert coordinates_of(conductor, Conductor()) == ("alpha",)
    assert coordinates_of(glossy, Glossy()) == ("ior", "alpha")
    found = albedo_of(glossy, Glossy(alpha=0.25, ior=1.5), jnp.asarray(0.7))
    assert found is not None
    assert float(found) == pytest.approx(float(glossy(r=0.5, F0=0.04, mu=0.7)), rel=1e-12)


def test_nothing_given_is_nothing_found():
    assert albedo_of(None, Conductor(), jnp.asarray(0.5)) is None


def test_a_coordinate_that_the_model_lacks_is_refused():
    glossy = ecfit.published("sforza-pellacini-2022-glossy")
    # A conductor with F = 1 has an F0 that has no effect.
    with pytest.raises(EcfitError, match="Conductor has no parameter 'F0'"):
        coordinates_of(glossy, Conductor())
    assert np.isfinite(float(glossy(r=0.5, F0=0.5, mu=0.5)))
