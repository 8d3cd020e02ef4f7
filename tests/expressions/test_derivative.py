"""Derivatives as expressions agree with automatic differentiation, kinks and guards included."""

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.expressions import derivative, evaluate, parse, substitute, value, var
from ecfit.expressions.evaluate import NUMPY
from ecfit.expressions.node import step

TEXTS = [
    "3*x*x*y - y/x + 2",
    "sqrt(x + y*y)/(1 + x)",
    "exp(-x*y) + exp2(x) - log(x + 1)",
    "abs(x - 0.5)*y",
    "min(x, y) + 2*max(x*x, 0.3)",
    "saturate(3*x - 1)**3",
    "x**2.3 + x**1.5 - (x - y)**-2",
    "7 - y",
]


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("name", ["x", "y"])
def test_it_agrees_with_automatic_differentiation(text, name):
    node = parse(text, ("x", "y"))
    rng = np.random.default_rng(1)
    at = {"x": rng.uniform(0.05, 1.0, 50), "y": rng.uniform(1.1, 2.0, 50)}

    def f(x, y):
        return value(node, {"x": x, "y": y})

    slope = jax.vmap(jax.grad(f, argnums=("x", "y").index(name)))(jnp.asarray(at["x"]), jnp.asarray(at["y"]))
    found = np.broadcast_to(value(derivative(node, name), at), 50)
    np.testing.assert_allclose(found, slope, rtol=1e-12, atol=1e-14)


def test_below_a_limit_the_slope_is_zero_and_at_it_that_of_the_first_argument():
    node = derivative(parse("max(x, 0.25)*3", ("x",)), "x")
    np.testing.assert_array_equal(value(node, {"x": np.array([0.0, 0.25, 0.5])}), [0.0, 3.0, 3.0])


def test_a_step_keeps_single_precision():
    node = step(var("x"), 0.5)
    found = value(node, {"x": np.array([0.25, 0.5, 0.75], dtype=np.float32)})
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, [0.0, 1.0, 1.0])


def test_the_second_derivative_is_the_derivative_of_the_first():
    node = parse("x**4*y", ("x", "y"))
    twice = derivative(derivative(node, "x"), "x")
    assert evaluate([twice], {"x": 2.0, "y": 3.0}, NUMPY, float) == [144.0]


def test_a_derivative_by_what_does_not_occur_is_zero():
    node = derivative(substitute(parse("x*x", ("x",)), {}), "z")
    assert (node.op, node.value) == ("const", 0.0)
