"""Maps: increasing, and undone by their inverses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit._jax import jax, jnp
from ecfit.coordinates import MAPS

# Sane magnitudes: the fourth power of 1e-90 underflows in 64 bits.
FINITE = st.floats(1e-6, 1e6)


def inside(name: str, x: float) -> float:
    """A number of the map's range, from any positive one."""
    map_ = MAPS[name]
    return x if np.isinf(map_.high) else map_.low + (map_.high - map_.low) * x / (1.0 + x)


@pytest.mark.parametrize("name", MAPS)
@given(x=FINITE)
def test_inverse_undoes_forward(name, x):
    map_ = MAPS[name]
    x = inside(name, x)
    # Near F0 = 1 the index of refraction is ill-conditioned in F0: its last digit is 1e-16 of 1 - F0.
    scale = 1.0 if name != "F0-to-ior" else 1.0 / (1.0 - x)
    assert map_.inverse(map_.forward(x)) == pytest.approx(x, rel=1e-14 * max(scale, 1.0), abs=1e-15)


@pytest.mark.parametrize("name", MAPS)
@given(x=FINITE, y=FINITE)
def test_forward_increases(name, x, y):
    x, y = sorted((inside(name, x), inside(name, y)))
    assert MAPS[name].forward(x) <= MAPS[name].forward(y)


@pytest.mark.parametrize("name", MAPS)
def test_a_map_treats_numbers_and_arrays_of_numpy_and_jax_alike(name):
    map_ = MAPS[name]
    x = np.linspace(0.1, 0.9, 5)
    for function in (map_.forward, map_.inverse):
        expected = [function(float(v)) for v in x + 1.0 * (function is map_.inverse)]
        given_ = x + 1.0 * (function is map_.inverse)
        np.testing.assert_allclose(function(given_), expected, rtol=1e-15)
        np.testing.assert_allclose(jax.jit(function)(jnp.asarray(given_)), expected, rtol=1e-15)


def test_F0_of_glass_is_four_percent():
    assert MAPS["F0-to-ior"].inverse(1.5) == pytest.approx(0.04, rel=1e-15)
    assert MAPS["F0-to-ior"].forward(0.04) == pytest.approx(1.5, rel=1e-15)
    assert MAPS["F0-to-ior"].forward(0.0) == 1.0


@pytest.mark.parametrize("number", [float, np.float64, np.asarray, jnp.asarray])
def test_full_reflectance_is_an_infinite_index(number):
    """Both ways and without a warning, which the tests take for errors."""
    map_ = MAPS["F0-to-ior"]
    assert float(map_.forward(number(1.0))) == np.inf
    assert float(map_.inverse(number(np.inf))) == 1.0


def test_F0_is_the_same_from_either_side():
    assert MAPS["F0-to-ior"].inverse(1.0 / 1.5) == pytest.approx(0.04, rel=1e-14)
