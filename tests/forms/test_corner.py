"""The corner chart covers the domain, and tells boxes that lie outside."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.forms.corner import ChartDomain

UNIT = (0.0, 1.0)
RANGES = st.tuples(st.floats(0.0, 0.9), st.floats(0.05, 1.0)).map(lambda p: (p[0], min(p[0] + p[1], 1.0)))


@given(RANGES, RANGES, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_every_point_of_the_domain_lies_in_a_box_that_is_not_outside(alpha, mu, a, m):
    domain = ChartDomain.of({"alpha": alpha, "mu": mu, "F0": UNIT})
    x = min(alpha[0] + a * (alpha[1] - alpha[0]), alpha[1])
    y = min(mu[0] + m * (mu[1] - mu[0]), mu[1])
    rho = x + y
    t = x / rho if rho > 0.0 else 0.5
    for name, at in (("t", t), ("rho", rho)):
        low, high = domain.box[name]
        assert low - 1e-14 <= at <= high + 1e-14
    boxes = {"t": (np.array([t]), np.array([t])), "rho": (np.array([rho]), np.array([rho]))}
    # A point is a box without width: rounding may put one on the edge outside, not one within.
    inner = min(x - alpha[0], alpha[1] - x, y - mu[0], mu[1] - y) > 1e-12
    assert not (inner and domain.outside(boxes)[0])
    back = domain.place({"t": t, "rho": rho, "F0": 0.5})
    assert back["alpha"] == pytest.approx(x, abs=1e-12)
    assert back["mu"] == pytest.approx(y, abs=1e-12)
    assert back["F0"] == 0.5


def test_boxes_beyond_the_ranges_are_outside():
    domain = ChartDomain.of({"alpha": UNIT, "mu": UNIT})
    low, high = (
        np.array([[0.8, 1.3], [0.0, 1.3], [0.4, 0.4]]).T,
        np.array([[1.0, 2.0], [0.1, 2.0], [0.6, 2.0]]).T,
    )
    boxes = {"t": (low[0], high[0]), "rho": (low[1], high[1])}
    assert domain.outside(boxes).tolist() == [True, True, False]
    assert domain.constraint is not None


def test_one_coordinate_alone_needs_no_constraint():
    only = ChartDomain.of({"alpha": (0.1, 1.0)})
    assert only.box["t"] == (1.0, 1.0)
    assert only.box["rho"] == pytest.approx((0.1, 1.0))
    assert only.constraint is None
    assert ChartDomain.of({"mu": UNIT}).box["t"] == (0.0, 0.0)
    assert dict(ChartDomain.of({"ior": (1.0, 3.0)}).box) == {"ior": (1.0, 3.0)}
