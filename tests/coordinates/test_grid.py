"""Grids: the last axis varies fastest, and coordinates go with their entries."""

import numpy as np
import pytest

from ecfit.coordinates import Axis, Grid
from ecfit.errors import EcfitError

R = Axis.spaced("r", 3, 0.5, 1.0, "clamped")
MU = Axis.given("mu", [0.1, 0.2, 0.4, 0.8])


def test_flat_indices_are_in_c_order():
    grid = Grid((R, MU))
    assert (grid.shape, grid.size, grid.names) == ((3, 4), 12, ("r", "mu"))
    flat = np.arange(12)
    nodes, nominal = grid.nodes_at(flat), grid.nominal_at(flat)
    np.testing.assert_array_equal(nodes["mu"].reshape(3, 4)[1], MU.nodes)
    np.testing.assert_array_equal(nodes["r"].reshape(3, 4)[:, 0], [0.5, 0.5, 1.0])
    np.testing.assert_array_equal(nominal["r"].reshape(3, 4)[:, 0], [0.0, 0.5, 1.0])


def test_the_domain_is_that_of_the_coordinates_a_fit_sees():
    assert Grid((R, MU)).domain == ((0.0, 1.0), (0.1, 0.8))


def test_names_must_differ():
    with pytest.raises(EcfitError, match="repeat: mu, mu"):
        Grid((MU, MU))


def test_a_grid_needs_an_axis():
    with pytest.raises(EcfitError, match="at least one"):
        Grid(())
