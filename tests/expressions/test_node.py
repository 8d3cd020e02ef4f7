"""One object for each subexpression, trivial arithmetic simplified, powers sharing their factors."""

import gc

import numpy as np
import pytest

from ecfit.expressions import const, cost, maximum, power, sqrt, substitute, value, var
from ecfit.expressions.node import inputs, replaced, topological

x, y = var("x"), var("y")


def test_equal_expressions_are_one_object():
    assert x + y is x + y
    assert x * 2.0 is x * const(2.0)
    assert x - y is not y - x
    assert const(0.0) is not const(-0.0)


def test_trivial_arithmetic_disappears():
    assert x + 0.0 is x
    assert 0.0 + x is x
    assert x - 0.0 is x
    assert 1.0 * x is x
    assert x / 1.0 is x
    assert (x * 0.0).op == "const"
    assert (0.0 - x).op == "neg"
    assert (-const(2.0)).value == -2.0


@pytest.mark.parametrize("exponent", [0, 1, 2, 3, 7, 0.5, 0.25, 0.75, 1.5, 3.25, 64, 0.3, 70, -2, -0.5])
def test_powers(exponent: float):
    points = {"x": np.linspace(0.2, 1.7, 7)}
    out = np.broadcast_to(value(power(x, exponent), points), (7,))
    assert np.allclose(out, points["x"] ** exponent, rtol=1e-14)


def test_powers_share_their_factors():
    assert cost(power(x, 4) + power(x, 8)).products == 3
    assert power(x, 2.5) is x * x * sqrt(x)


def test_substitution_and_replacement():
    node = x * y + sqrt(x)
    assert substitute(node, {"x": y}) is y * y + sqrt(y)
    assert substitute(node, {"x": const(1.0)}) is y + sqrt(const(1.0))
    assert replaced(node, {x * y: var("z")}) is var("z") + sqrt(x)
    assert inputs(node) == {"x", "y"}


def test_order_puts_arguments_first_and_each_once():
    node = maximum(x * x + x, x * x)
    order = topological([node])
    assert len(order) == len({id(n) for n in order}) == 4
    assert all(order.index(a) < order.index(n) for n in order for a in n.args)


def test_long_sums_do_not_recurse():
    total = const(0.0)
    for i in range(5000):
        total = total + x * float(i)
    assert float(value(total, {"x": np.float64(1.0)})) == 4999 * 2500


def test_unused_nodes_are_freed():
    from ecfit.expressions.node import _known

    gc.collect()
    before = len(_known)
    node = var("only here") * 123.456
    assert len(_known) > before
    del node
    gc.collect()
    assert len(_known) <= before


def test_text():
    assert repr(x * 2.0 + sqrt(y)) == "add(mul(x, 2.0), sqrt(y))"
    assert repr(power(x, 0.3)) == "pow(x, 0.3)"
