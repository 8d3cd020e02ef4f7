"""One tree under several arithmetics."""

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.expressions import cost, evaluate, parse, value, var
from ecfit.expressions.evaluate import NUMPY

TEXT = "sqrt(x)*exp(-y) + log(1 + x) - exp2(y)/(1 + abs(x - y)) + min(x, y)**2 - max(x, 0.3)**0.3"
NODE = parse(TEXT, ("x", "y"))


def expected(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    out = np.sqrt(x) * np.exp(-y) + np.log(1 + x) - 2.0**y / (1 + np.abs(x - y))
    return out + np.minimum(x, y) ** 2 - np.maximum(x, 0.3) ** 0.3


def points(kind: type = np.float64) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    return {n: rng.uniform(0.1, 1.0, 50).astype(kind) for n in "xy"}


def test_numpy_and_jax_agree():
    at = points()
    assert np.allclose(value(NODE, at), expected(**at), rtol=1e-14)
    found = value(NODE, {n: jnp.asarray(p) for n, p in at.items()})
    assert np.allclose(found, expected(**at), rtol=1e-13)


def test_jit_and_gradients():
    def f(x, y):
        return value(NODE, {"x": x, "y": y})

    assert float(jax.jit(f)(0.4, 0.6)) == pytest.approx(float(expected(np.float64(0.4), np.float64(0.6))))
    step = 1e-6
    slope = (expected(np.float64(0.4 + step), 0.6) - expected(np.float64(0.4 - step), 0.6)) / (2 * step)
    assert float(jax.grad(f)(0.4, 0.6)) == pytest.approx(float(slope), rel=1e-6)


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_narrow_arithmetic_stays_narrow(kind: type):
    at = points(kind)
    found = value(NODE, at)
    assert found.dtype == kind
    wide = expected(**{n: p.astype(np.float64) for n, p in at.items()})
    assert np.abs(found - wide).max() < 20 * np.finfo(kind).eps
    assert np.abs(found - wide).max() > 0.0


def test_inputs_broadcast():
    assert np.asarray(value(var("x") * var("y"), {"x": np.ones((3, 1)), "y": np.ones(4)})).shape == (3, 4)


def test_shared_subexpressions_are_computed_once():
    calls = []

    def exp(x):
        calls.append(1)
        return np.exp(x)

    shared = parse("exp(x)", ("x",))
    evaluate([shared + shared * shared, shared], {"x": np.float64(1.0)}, {**NUMPY, "exp": exp}, float)
    assert len(calls) == 1


def test_costs():
    found = cost(parse("(x*y + 1)/(2 + sqrt(x)) - exp(y) + min(x, y)", ("x", "y")))
    assert (found.products, found.divisions, found.roots) == (1, 1, 1)
    assert (found.transcendentals, found.comparisons) == (1, 1)
    assert found.adds == 4
    assert found.multiply_adds == 4
    assert found.total == 4 + 1 + 5.0 + 4.0 + 4.0
    assert str(found) == "4 multiply-adds, 1 division, 1 root, 1 transcendental, 1 comparison"
    assert cost(parse("-abs(x)", ("x",))).total == 0.0
