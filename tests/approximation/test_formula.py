"""Formulas of every kind: one value in NumPy, JAX and as an expression; files that read back exactly."""

import json

import jax.numpy as jnp
import numpy as np
import pytest

from ecfit.approximation import Approximation, Lookup, Quotient, StructuredFormula, Written
from ecfit.approximation.composed import Composed, Part
from ecfit.approximation.formula import broadcast, power_product
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.expressions import value
from ecfit.forms import Structure, Terms, head

STRUCTURE = Structure(
    head("corner"), ("alpha", "mu"), (np.array([[1, 0], [0, 1]]),), np.array([[3, 0], [0, 3], [1.5, 1.5]])
)
STRUCTURED = StructuredFormula(STRUCTURE, np.array([0.1, 0.2, 1.0 / 3.0, 0.7]))
QUOTIENT = Quotient(
    Terms(np.array([[0, 0], [1, 2]]), np.array([[1, 0]])),
    np.array([0.3, 0.1, 1.0 / 7.0]),
    ((0.0, 1.0), (0.5, 2.0)),
)
WRITTEN = Written(("mu", "alpha"), "1 - y / (mu + 1.5)", (("y", "alpha**2 * 0.3"),))
COMPOSED = Composed(
    ("mu", "alpha"), "A * B", (Part("A", ("mu", "alpha"), STRUCTURED), Part("B", ("mu", "alpha"), WRITTEN))
)
LOOKUP = Lookup(np.arange(6.0).reshape(2, 3) / 7.0, ((0.0, 1.0), (0.0, 1.0)), ("identity", "square"))
ALL = {f.kind: f for f in (STRUCTURED, QUOTIENT, WRITTEN, COMPOSED, LOOKUP)}
NAMES = ("mu", "alpha")
POINTS = [np.random.default_rng(i).uniform(0.01, 1.0, 50) for i in range(2)]


@pytest.mark.parametrize("kind", ALL)
def test_numpy_jax_and_expression_agree(kind: str):
    formula = ALL[kind]
    expected = formula.value(POINTS)
    assert isinstance(expected, np.ndarray)
    np.testing.assert_allclose(formula.value([jnp.asarray(p) for p in POINTS]), expected, rtol=1e-13)
    if kind == "lookup":
        with pytest.raises(EcfitError, match="no expression"):
            formula.expression(NAMES)
    else:
        got = value(formula.expression(NAMES), dict(zip(NAMES, POINTS, strict=True)))
        np.testing.assert_allclose(got, expected, rtol=1e-12)


@pytest.mark.parametrize("kind", ALL)
def test_a_grid_is_the_product_of_its_nodes(kind: str):
    nodes = [np.linspace(0.1, 1.0, 4), np.linspace(0.2, 0.9, 3)]
    grid = ALL[kind].on_grid(nodes)
    assert grid.shape == (4, 3)
    np.testing.assert_allclose(grid, ALL[kind].value([nodes[0][:, None], nodes[1]]), rtol=1e-13)


@pytest.mark.parametrize("kind", ALL)
def test_files_read_back_bit_for_bit(kind: str):
    made = Approximation("a", "f", "1", NAMES, ALL[kind], ((0.0, 1.0), (0.0, 1.0)), Contract("unknown"))
    again = Approximation.from_dict(json.loads(json.dumps(made.to_dict())))
    assert again.to_dict() == made.to_dict()
    assert type(again.formula) is type(made.formula)
    np.testing.assert_array_equal(again.coefficients, made.coefficients)
    np.testing.assert_array_equal(again.formula.value(POINTS), made.formula.value(POINTS))


@pytest.mark.parametrize("kind", ["structured", "quotient", "written", "composed"])
def test_a_positive_denominator_is_bounded_from_below(kind: str):
    found = ALL[kind].smallest_denominator(((0.0, 1.0), (0.0, 1.0)))
    assert 0.0 < found.bound <= found.value


def test_the_rows_hold_all_numbers():
    rows = STRUCTURED.rows(NAMES)
    assert rows[0] == ("P: alpha", 0.1)
    assert ("Q: alpha^3", 1.0) in rows
    assert ("Q: alpha^1.5 mu^1.5", 0.7) in rows
    assert len(rows) == STRUCTURED.count + 1
    assert STRUCTURED.variables == 2


def test_single_precision_stays_single():
    assert STRUCTURED.value([p.astype(np.float32) for p in POINTS]).dtype == np.float32
    assert broadcast([1, 2.0])[0].dtype == np.float64
    assert power_product(("a", "b", "c"), (1, 0, 1.5)) == "a c^1.5"
    assert power_product(("a",), (0,)) == "1"


def approximation(kind: str) -> dict:
    made = Approximation("a", "f", "1", NAMES, ALL[kind], ((0.0, 1.0), (0.0, 1.0)), Contract("unknown"))
    return json.loads(json.dumps(made.to_dict()))


@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        ("structured", {"coefficients": [1.0]}, "a: 4 coefficients expected, got shape"),
        ("structured", {"coefficients": [1.0, 2.0, 3.0, float("nan")]}, "coefficients must be finite"),
        ("structured", {"structure": {}}, "key 'features' is missing"),
        ("structured", {"structure": None}, "malformed"),
        ("structured", {"variables": ["mu"], "domain": [[0, 1]]}, "differ in number"),
        ("quotient", {"coefficients": [1.0]}, "3 coefficients expected"),
        ("lookup", {"through": ["cube", "square"]}, "unknown map 'cube'"),
        ("lookup", {"grid": [1.0]}, "look-up needs"),
        ("written", {"formula": "1 - z"}, "unknown name 'z'"),
        ("composed", {"text": "A * C"}, "unknown name 'C'"),
        ("composed", {"parts": []}, "needs parts, each name once"),
        ("structured", {"kind": "spline"}, "unknown kind of formula 'spline'"),
    ],
)
def test_damaged_files_are_told(kind: str, change: dict, words: str):
    with pytest.raises(EcfitError, match=words) as caught:
        Approximation.from_dict({**approximation(kind), **change}, "a")
    assert "\n" not in str(caught.value)


def test_a_structured_form_keeps_its_variables_order():
    with pytest.raises(EcfitError, match="function of mu, alpha"):
        STRUCTURED.expression(("alpha", "mu"))
