"""The pieces cover the chart, are the same function there, and make half powers provable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.expressions import parse, value
from ecfit.expressions.bounds import smallest
from ecfit.expressions.node import topological
from ecfit.forms.corner import ChartDomain
from ecfit.forms.rooted import pieces

UNIT = (0.0, 1.0)
NAMES = ("t", "rho", "F0", "ior")
# Half and quarter powers of everything that has a root, and a coordinate that has none.
MIXED = parse("sqrt(t)*rho + sqrt(1 - t)*sqrt(rho) + sqrt(sqrt(F0))*t*ior - F0*(1 - t)*sqrt(1 - t)", NAMES)
RANGES = st.tuples(st.floats(0.0, 0.95), st.floats(0.0, 1.0)).map(lambda p: (p[0], min(p[0] + p[1], 1.0)))


def _roots(piece, at):
    found = {}
    for name, (low, high) in piece.box.items():
        plain = name.removeprefix("root_")
        x = at[plain]
        if name == "root_t":
            x = np.sqrt(1.0 - x) if piece.mirrored else np.sqrt(x)
        elif name.startswith("root_"):
            x = x ** (0.25 if plain == "F0" else 0.5)
        found[name] = (x, low, high)
    return found


@given(RANGES, RANGES, RANGES, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_every_point_of_the_box_lies_in_a_piece_with_the_same_value(t, rho, f0, a, b, c):
    box = {"t": t, "rho": rho, "F0": f0, "ior": (1.5, 2.0)}
    ends = zip(box.values(), (a, b, c, 0.5), strict=True)
    at = {n: np.float64(lo + u * (hi - lo)) for n, ((lo, hi), u) in zip(box, ends, strict=True)}
    held = 0
    for piece in pieces(box, MIXED):
        roots = _roots(piece, at)
        if all(low - 1e-12 <= x <= high + 1e-12 for x, low, high in roots.values()):
            held += 1
            points = {n: x for n, (x, _, _) in roots.items()}
            assert value(piece.rooted(MIXED), points) == pytest.approx(value(MIXED, at), abs=1e-12)
            back = piece.chart(points)
            assert {n: float(x) for n, x in back.items()} == pytest.approx(at, abs=1e-12)
    assert held


@given(RANGES)
def test_ends_are_rounded_outward(ends):
    for piece in pieces({"rho": ends, "F0": ends}, MIXED):
        (rho, f0) = piece.box.values()
        assert rho[0] ** 2 <= ends[0] <= ends[1] <= rho[1] ** 2
        assert f0[0] ** 4 <= ends[0] <= ends[1] <= f0[1] ** 4


def test_no_root_is_left_of_what_the_piece_has_roots_of():
    first, second = pieces({"t": UNIT, "rho": (0.0, 2.0), "F0": UNIT, "ior": (1.0, 2.0)}, MIXED)
    assert not first.mirrored
    assert second.mirrored
    for piece in (first, second):
        left = [n for n in topological([piece.rooted(MIXED)]) if n.op == "sqrt"]
        assert len(left) == 1  # of 1 - x^2, which is smooth on the piece


def test_half_powers_that_nearly_cancel_are_bounded():
    # 1e-4 + (sqrt(t) + rho - 1)^2, multiplied out: bounds in t itself do not end.
    text = "1e-4 + 1 - 2*(sqrt(t) + rho) + (sqrt(t)*sqrt(t) + 2*sqrt(t)*rho + rho*rho)"
    domain = ChartDomain.of({"alpha": UNIT, "mu": UNIT})
    node = parse(text, NAMES)
    found = domain.smallest(node, enough=0.0, limit=50_000)
    assert 0.0 < found.bound <= 1e-4 <= found.value < 1.01e-4
    at = dict(zip(domain.box, found.place, strict=True))
    assert np.sqrt(at["t"]) + at["rho"] == pytest.approx(1.0, abs=1e-3)
    direct = smallest(node, domain.box, enough=0.0, constraint=domain.constraint, limit=50_000)
    assert direct.bound < 0.0


def test_one_coordinate_alone():
    node = parse("sqrt(rho) - rho", NAMES)
    found = ChartDomain.of({"alpha": (0.04, 0.49)}).smallest(node)
    assert found.value == pytest.approx(0.16, abs=1e-3)
    assert found.bound <= 0.16
    assert found.place == pytest.approx((1.0, 0.04), abs=1e-9)


def test_a_coordinate_without_roots_stays_exact():
    node = parse("1 - F0 + 0*sqrt(t)", NAMES)
    assert "F0" in pieces({"t": UNIT, "rho": UNIT, "F0": UNIT}, node)[0].box
    assert ChartDomain.of({"alpha": UNIT, "mu": UNIT, "F0": UNIT}).smallest(node).bound >= 0.0
