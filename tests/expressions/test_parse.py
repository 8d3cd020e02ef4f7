"""Text becomes an expression; anything that is not arithmetic is refused and nothing is executed."""

import contextlib

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.expressions import parse, value, var

NAMES = ("x", "y")
POINT = {"x": np.float64(0.3), "y": np.float64(0.7)}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x + y*2 - 1", 0.7),
        ("-x**2", -0.09),
        ("+x/y", 0.3 / 0.7),
        ("x**-1", 1.0 / 0.3),
        ("x**1.5 + y**0.25", 0.3**1.5 + 0.7**0.25),
        ("sqrt(x) + exp(y) + log(x) + exp2(y)", 0.3**0.5 + np.exp(0.7) + np.log(0.3) + 2**0.7),
        ("min(x, y) + max(x, 2) + abs(-y)", 3.0),
        ("saturate(x + y) + saturate(-x)", 1.0),
        ("  1e-3 ", 1e-3),
    ],
)
def test_arithmetic(text: str, expected: float):
    assert float(value(parse(text, NAMES), POINT)) == pytest.approx(expected, rel=1e-14)


def test_definitions_come_one_after_the_other():
    node = parse("b*x", ("x",), (("a", "x + 1"), ("b", "a*a")))
    assert node is (var("x") + 1.0) * (var("x") + 1.0) * var("x")
    for lets in ((("x", "1"),), (("a", "b"), ("b", "1")), (("a", "1"), ("a", "2")), (("a b", "1"),)):
        with pytest.raises(EcfitError, match="formula: "):
            parse("x", ("x",), lets)


MALICIOUS = [
    "__import__('os').system('true')", "x.real", "().__class__", "x[0]", "(lambda: 1)()", "[x for x in (1,)]",
    "open('f')", "print(x)", "eval('1')", "x if y else 1", "x < y", "x and y", "not x", "x // y", "x % y",
    "x @ y", "~x", "'text'", "None", "True", "1j", "f'{x}'", "sqrt(x=1)", "sqrt(*[x])", "x := 1", "x; y",
    "import os", "", "x +", "{1: 2}", "...", "x\x00", "sqrt.__call__(x)",
]  # fmt: skip


@pytest.mark.parametrize("text", MALICIOUS)
def test_anything_else_is_refused(text: str):
    with pytest.raises(EcfitError, match="formula: "):
        parse(text, NAMES)


@pytest.mark.parametrize("text", ["x**y", "x**(1/x)", "2**x"])
def test_exponents_must_be_numbers(text: str):
    with pytest.raises(EcfitError, match="exponent must be a number"):
        parse(text, NAMES)


def test_large_exponents_do_not_unroll(no_hang: None):
    node = parse("x**100000000", NAMES)
    assert node.op == "pow"
    assert float(value(node, POINT)) == 0.0


@pytest.mark.parametrize("text", ["9**9**9**9", "10**400", "1e999*x", "0**-1", "2**100000*x"])
def test_numbers_out_of_range_raise_nothing_but_our_error(text: str, no_hang: None):
    with contextlib.suppress(EcfitError):
        parse(text, NAMES)


@pytest.mark.parametrize(
    "text", ["(" * 5000 + "x" + ")" * 5000, "-" * 15000 + "x", "x" * 30000, "+".join(["x"] * 9000)]
)
def test_deep_and_long_texts_are_refused_or_read(text: str, no_hang: None):
    message = ""
    try:
        parse(text, NAMES)
    except EcfitError as error:
        message = str(error)
    assert len(message) < 200


def test_unknown_names_list_a_near_one():
    with pytest.raises(EcfitError, match="unknown name 'alpa'; did you mean 'alpha'"):
        parse("alpa", ("alpha", "mu"))
    with pytest.raises(EcfitError, match="no function 'sin'"):
        parse("sin(x)", NAMES)
    with pytest.raises(EcfitError, match="takes 2 arguments"):
        parse("min(x)", NAMES)


def test_text_of_another_type_is_refused():
    with pytest.raises(EcfitError, match="expected text"):
        parse(3, NAMES)  # type: ignore[arg-type]
