"""Integration at scattered points agrees with tables, and refuses what it does not know."""

import numpy as np
import pytest

import ecfit
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.quadrature.refine import Status
from ecfit.tables.scattered import integrate


def test_points_of_a_grid_have_the_table_s_values():
    table = ecfit.tabulate("conductor", {"r": [0.2, 0.5, 0.9], "mu": [0.1, 0.6]}, tolerance=1e-5)
    r, mu = (m.ravel() for m in np.meshgrid(*(a.nodes for a in table.axes), indexing="ij"))
    found = integrate(table.contract, {"r": r, "mu": mu}, 1e-5)
    assert np.allclose(found.values, table.values.ravel(), rtol=0.0, atol=2e-5)
    assert np.all(found.status == Status.CONVERGED)
    assert np.all(found.errors <= 1e-5)
    by_alpha = integrate(table.contract, {"mu": mu, "alpha": r * r}, 1e-5)
    assert np.allclose(by_alpha.values, found.values, atol=1e-12)


def test_no_points():
    assert integrate(Contract("conductor"), {"r": np.empty(0), "mu": np.empty(0)}).values.shape == (0,)


HALF = np.array([0.5])


@pytest.mark.parametrize(
    ("contract", "points", "message"),
    [
        (Contract("unknown"), {"r": HALF, "mu": HALF}, "names no model"),
        (Contract("nothing"), {"r": HALF, "mu": HALF}, "unknown model"),
        (Contract("conductor", {"masking": "none"}), {"r": HALF, "mu": HALF}, "masking"),
        (Contract("conductor"), {"r": HALF}, "mu"),
        (Contract("conductor"), {"r": HALF, "mu": np.array([0.1, 0.2])}, "one length"),
        (Contract("conductor"), {"r": 2.0 * HALF * 1.5, "mu": HALF}, "within"),
        (Contract("conductor"), {"r": HALF, "alpha": HALF, "mu": HALF}, "more than once"),
        (Contract("conductor"), {"x": HALF, "mu": HALF}, "x"),
    ],
)
def test_what_it_refuses(contract: Contract, points: dict, message: str):
    with pytest.raises(EcfitError, match=message):
        integrate(contract, points)
