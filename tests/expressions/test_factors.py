"""Factors multiply to the expression, and show what its terms share."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ecfit.expressions import Node, const, parse, sqrt, value, var
from ecfit.expressions.factors import factors, product

NAMES = ("x", "y")


def always(_: Node) -> bool:
    return True


def multiplied(parts: dict[Node, float], points: dict) -> np.ndarray:
    out = np.ones(1)
    for base, exponent in parts.items():
        out = out * np.asarray(value(base, points)) ** exponent
    return out


TEXTS = st.sampled_from(
    ["x*y + x*x", "x/y - x", "1 - x/(1 + y)", "sqrt(x)*y + x*y*y", "(1 - x)**3 - (1 - x)*y",
     "-(x*y) + 3*x*y", "x/(1 + x) + y/(1 + x)", "sqrt(x*x*y) - sqrt(x)"]
)  # fmt: skip


@settings(max_examples=40)
@given(TEXTS, st.floats(0.05, 0.9), st.floats(0.05, 0.9))
def test_the_product_is_the_expression(text: str, x: float, y: float):
    points = {"x": np.array([x]), "y": np.array([y])}
    node = parse(text, NAMES)
    assert np.allclose(multiplied(factors(node, always), points), value(node, points), rtol=1e-12, atol=1e-14)


def test_what_all_terms_share_is_taken_out():
    u = 1.0 - var("mu")
    parts = factors(u * u * u * u * u - u * var("x"), always)
    assert parts[u] == 1.0
    parts = factors(parse("x*y**3 + x**2*y", NAMES), always)
    assert parts[var("x")] == 1.0
    assert parts[var("y")] == 1.0
    assert len(parts) == 3


def test_roots_are_taken_apart_only_where_that_is_allowed():
    node = sqrt(var("x") * var("y"))
    assert factors(node, always) == {var("x"): 0.5, var("y"): 0.5}
    assert factors(node, lambda _: False) == {node: 1.0}


def test_products_of_powers():
    assert product({}) is const(1.0)
    assert product({var("x"): 2.0, var("y"): 0.5}) is var("x") * var("x") * sqrt(var("y"))
