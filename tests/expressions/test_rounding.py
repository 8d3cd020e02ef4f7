"""Bounds of the rounding error in single precision hold, and are not absurd."""

import numpy as np
import pytest

from ecfit.expressions import Node, parse, substitute, value, var
from ecfit.expressions import interval as iv
from ecfit.expressions.evaluate import evaluate
from ecfit.expressions.interval import Interval
from ecfit.expressions.rounding import UNIT, Analysis

TEXTS = [
    "x*y + 0.1", "(x - y)/(1 + x*x)", "sqrt(x*y) - x/3", "exp(-3*x)*y", "log(1 + x) + exp2(y)",
    "max(x, y)*min(x, 0.3)", "abs(x - y)**3", "1 - (0.3*x**3 + 0.7*y)/(0.2 + x + y**2)", "x**0.3 + y**1.7",
]  # fmt: skip


def bound(node: Node, boxes: dict[str, Interval]) -> np.ndarray:
    analysis = Analysis(node, None, {})
    with np.errstate(all="ignore"):
        inputs = {n: analysis.input(0.0, x) for n, x in boxes.items()}
        return analysis.plain(evaluate([node], inputs, analysis.rules, analysis.constant)[0])


@pytest.mark.parametrize("text", TEXTS)
def test_measured_errors_lie_below_the_bound(text: str):
    node = parse(text, ("x", "y"))
    rng = np.random.default_rng(2)
    narrow = {n: rng.uniform(0.01, 1.0, 5000).astype(np.float32) for n in "xy"}
    wide = {n: p.astype(np.float64) for n, p in narrow.items()}
    error = np.abs(np.asarray(value(node, narrow), dtype=np.float64) - value(node, wide))
    pointwise = bound(node, {n: Interval(p, p) for n, p in wide.items()})
    assert np.all(error <= pointwise)
    overall = bound(node, {n: Interval(0.01, 1.0) for n in "xy"})
    assert np.max(pointwise) <= overall
    assert np.max(pointwise) < 200 * UNIT


def test_a_single_rounding_is_one_unit():
    found = bound(parse("x*y", ("x", "y")), {n: iv.point(1.0) for n in "xy"})
    assert UNIT <= found <= 1.001 * UNIT
    # Constants count where they are not single precision numbers.
    assert bound(parse("x + 0.5", ("x",)), {"x": iv.point(0.5)}) <= 1.001 * UNIT
    assert bound(parse("x + 0.1", ("x",)), {"x": iv.point(0.5)}) > 0.6 * UNIT


def test_divisors_that_may_vanish_give_no_bound_unless_it_is_known_that_they_do_not():
    node = parse("x/(1 + x - y)", ("x", "y"))
    box = {"x": Interval(0.0, 1.0), "y": Interval(0.0, 1.0)}
    assert bound(node, box) == np.inf
    analysis = Analysis(node, None, {1.0 + var("x") - var("y"): 0.2})
    inputs = {n: analysis.input(0.0, x) for n, x in box.items()}
    with np.errstate(all="ignore"):
        found = analysis.plain(evaluate([node], inputs, analysis.rules, analysis.constant)[0])
    assert found < 200 * UNIT


def test_overflow_of_single_precision_gives_no_bound():
    assert bound(parse("x*x", ("x",)), {"x": iv.point(1e20)}) == np.inf


def test_powers_of_rho_resolve_the_corner():
    # x / (x + y) with x = rho t, y = rho (1 - t) is t: harmless although 0 / 0 at rho = 0.
    node = parse("x**3/(x**3 + y**3)", ("x", "y"))
    rho, t = Interval(1e-6, 1.0), Interval(0.4, 0.5)
    analysis = Analysis(node, rho, {})
    inputs = {"x": analysis.input(1.0, t), "y": analysis.input(1.0, iv.sub(iv.point(1.0), t))}
    with np.errstate(all="ignore"):
        found = evaluate([node], inputs, analysis.rules, analysis.constant)[0]
    assert found.order == 0.0
    assert analysis.plain(found) < 100 * UNIT
    plain = substitute(node, {})
    assert plain is node
