"""The furnace's account of its deviations."""

import numpy as np
import pytest

from ecfit.compensation import Furnace
from ecfit.coordinates import Axis


@pytest.fixture
def found(make_table) -> Furnace:
    """1.02 in one corner, 0.9 in another, 1 elsewhere."""
    r, mu = Axis.given("r", [0.2, 0.6]), Axis.given("mu", [0.1, 0.5, 0.9])

    def f(r, mu):
        return 1.0 + 0.02 * ((r == 0.2) & (mu == 0.1)) - 0.1 * ((r == 0.6) & (mu == 0.9))

    return Furnace(make_table(f, r, mu))


def test_deviations_have_their_sign(found):
    np.testing.assert_allclose(found.deviation, [[0.02, 0.0, 0.0], [0.0, 0.0, -0.1]], atol=1e-15)


def test_mean_and_largest_are_of_the_absolute_deviation(found):
    assert found.mean == pytest.approx(0.12 / 6.0)
    assert found.max == pytest.approx(0.1)
    assert found.mean < found.p99 <= found.max


def test_the_place_of_the_largest_is_told_in_true_coordinates(found):
    assert found.place == {"r": 0.6, "mu": 0.9}


def test_the_description_tells_lost_from_made_energy(found):
    first, second = found.describe()
    assert "largest 1.00e-01 at r = 0.6, mu = 0.9" in first
    assert "energy lost at most 1.00e-01, made at most 2.00e-02" in second
    assert "0 of 6 integrals missed" in second
