"""Minima over boxes are bounded from below by proofs, attained from above, and quick to decide."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ecfit.errors import EcfitError
from ecfit.expressions import Node, const, parse, power, sqrt, unary, var
from ecfit.expressions.bounds import Examined, Search, smallest
from ecfit.expressions.evaluate import value

UNIT = (0.0, 1.0)


def at(node: Node, box: dict, place: tuple[float, ...]) -> float:
    return float(value(node, {n: np.float64(x) for n, x in zip(box, place, strict=True)}))


def sampled(node: Node, box: dict, count: int = 4000) -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.asarray(value(node, {n: rng.uniform(low, high, count) for n, (low, high) in box.items()}))


KNOWN = [
    ("(x - 0.3)**2 + (y - 0.7)**2 + 0.1", {"x": UNIT, "y": UNIT}, 0.1),
    ("x*y - x", {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}, -2.0),
    ("exp(x) - x", {"x": (-2.0, 2.0)}, 1.0),
    ("max(x, 1 - x) + abs(y)", {"x": UNIT, "y": (-1.0, 1.0)}, 0.5),
    ("sqrt(x)*sqrt(y) - 0.5*x - 0.5*y + 3", {"x": UNIT, "y": UNIT}, 2.5),
    ("(x - 0.3137)**2 - 1e-6", {"x": UNIT}, -1e-6),
    ("1/(0.1 + x*y*z)", {"x": UNIT, "y": UNIT, "z": UNIT}, 1.0 / 1.1),
]


@pytest.mark.parametrize(("text", "box", "minimum"), KNOWN)
def test_known_minima(text: str, box: dict, minimum: float):
    node = parse(text, tuple(box))
    found = smallest(node, box)
    assert found.bound <= minimum <= found.value
    assert found.value - found.bound <= 1.01e-3 * abs(found.value)
    assert at(node, box, found.place) == pytest.approx(found.value, abs=1e-12)


@settings(max_examples=30)
@given(st.integers(1, 3), st.integers(0, 10**6))
def test_bounds_lie_below_samples_and_values_are_attained(variables: int, seed: int):
    rng = np.random.default_rng(seed)
    names = ("x", "y", "z")[:variables]
    box = {n: tuple(sorted(rng.uniform(0.0, 2.0, 2))) for n in names}
    total: Node = const(float(rng.normal()))
    for _ in range(6):
        term: Node = const(float(rng.normal()))
        for name in names:
            term = term * power(var(name), float(rng.choice([0, 0.5, 1, 1.5, 2, 3])))
        total = total + term
    found = smallest(total, box, limit=30_000)
    assert found.bound <= sampled(total, box).min() + 1e-12
    assert found.bound <= found.value
    assert at(total, box, found.place) == pytest.approx(found.value, abs=1e-9)
    assert all(low <= x <= high for x, (low, high) in zip(found.place, box.values(), strict=True))


def test_touching_zero_is_not_called_positive_nor_negative_where_it_is_exact():
    box = {"x": UNIT, "y": UNIT}
    found = smallest(parse("x**2 + y**3", ("x", "y")), box)
    assert found.bound == found.value == 0.0
    # Here rounding and dependence leave a bound just below.
    found = smallest(parse("(x - y)*(x - y) + 0*x", ("x", "y")), box, limit=20_000)
    assert found.value == 0.0
    assert -1e-3 < found.bound <= 0.0


def test_poles_are_found():
    q = parse("0.2 - x*y + (x - y)**2", ("x", "y"))
    found = smallest(q, {"x": UNIT, "y": UNIT}, enough=0.0)
    assert found.value < 0.0
    assert found.bound < 0.0
    at_pole = smallest(parse("1/(x - 0.3)", ("x",)), {"x": UNIT}, limit=10_000)
    assert at_pole.bound == -np.inf


def test_enough_stops_early_and_stays_a_proof():
    node = parse("0.01 + (x - 0.3)**2*(y - 0.7)**2", ("x", "y"))
    box = {"x": UNIT, "y": UNIT}
    found = smallest(node, box, enough=0.0)
    assert 0.0 < found.bound <= 0.01
    tight = smallest(node, box)
    assert found.bound <= tight.bound


def test_what_touches_enough_is_not_refined_there():
    """A variable is >= 0: proved by the boxes that the search starts from, with no way down to x = 0."""
    seen: list[int] = []

    def examine(lows, highs):
        seen.append(len(lows))
        return Examined(lows[:, 0], lows, lows[:, 0], highs - lows)

    search = Search({"x": UNIT}, ("x",), None)
    assert search.run(examine, 1e-3, 0.0, 10_000).bound == 0.0
    assert len(seen) == 1
    assert search.run(examine, 1e-3, np.nextafter(0.0, 1.0), 10_000).bound == 0.0  # > 0 is not proved
    assert len(seen) > 10


def test_the_limit_leaves_a_bound_that_is_not_tight():
    # Heavily dependent: x - x + ... of different nodes.
    node = parse("(x + y)**3 - x**3 - 3*x**2*y - 3*x*y**2 - y**3", ("x", "y"))
    found = smallest(node, {"x": UNIT, "y": UNIT}, limit=500)
    assert found.bound <= -1e-12
    assert abs(found.value) < 1e-12


def test_a_constraint_removes_what_lies_outside():
    node = var("x") + var("y")

    def outside(boxes):
        (_, x), (_, y) = boxes["x"], boxes["y"]
        return x * x + y * y < 1.0  # wholly within the unit circle

    found = smallest(node, {"x": UNIT, "y": UNIT}, constraint=outside, tolerance=1e-2)
    assert 0.98 < found.bound <= 1.0 <= found.value < 1.02


def test_floors_of_divisors_bound_quotients():
    x = var("x")
    q = const(1e-6) + (x - 0.5) * (x - 0.5)
    proved = smallest(q, {"x": UNIT}).bound
    found = smallest(-(1.0 / q), {"x": UNIT}, floors={q: proved}, limit=300)
    assert -1.1e6 < found.bound <= -1e6
    below = smallest(1.0 / -q, {"x": UNIT}, floors={-q: -proved}, limit=300)
    assert below.bound == pytest.approx(found.bound, rel=0.1)


def test_constants_fixed_and_unused_variables():
    assert smallest(const(2.0), {"x": UNIT}).bound == 2.0
    found = smallest(parse("x - y", ("x", "y")), {"x": (0.5, 0.5), "y": UNIT, "z": UNIT})
    assert found.bound == pytest.approx(-0.5)
    assert found.place[:2] == (0.5, 1.0)


def test_undefined_everywhere_proves_nothing():
    found = smallest(sqrt(var("x") - 3.0), {"x": UNIT}, limit=2000)
    assert found.bound == -np.inf
    assert smallest(unary("log", var("x")), {"x": UNIT}, limit=2000).bound == -np.inf


def test_a_denominator_of_forty_terms_in_three_variables_is_quick(no_hang: None):
    rng = np.random.default_rng(5)
    total: Node = const(1.0)
    for _ in range(40):
        a, b, c = rng.integers(0, 4, 3)
        term = power(var("x"), a) * power(var("y"), b) * power(var("z"), 0.5 * c)
        total = total + float(rng.uniform(-0.05, 0.1)) * term
    found = smallest(total, dict.fromkeys("xyz", UNIT), enough=0.0)
    assert found.bound > 0.0


@pytest.mark.parametrize("box", [{}, {"x": (1.0, 0.0)}, {"x": (0.0, np.inf)}, {"x": (np.nan, 1.0)}])
def test_bad_boxes_are_refused(box: dict):
    with pytest.raises(EcfitError, match="bounds: "):
        smallest(var("x"), box)
