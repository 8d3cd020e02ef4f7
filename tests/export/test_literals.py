"""Literals are read as the number that is meant, and no shorter decimal is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.errors import EcfitError
from ecfit.export.literals import literal


@given(st.floats(allow_nan=False, allow_infinity=False, width=32))
def test_round_trip_in_single_precision(x):
    text = literal(x)
    assert np.float32(text) == np.float32(x)
    assert "." in text or "e" in text  # else it would be an integer in C and GLSL
    digits = text.strip("-").partition("e")[0].replace(".", "").strip("0")
    if 1 < len(digits) < 9:
        fewer = f"%.{len(digits) - 2}e" % np.float64(x)
        assert np.float32(fewer) != np.float32(x)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_round_trip_in_double_precision(x):
    assert float(literal(x, double=True)) == x


@pytest.mark.parametrize(
    ("x", "text"),
    [(0.516553, "0.516553f"), (1.0, "1.0f"), (-3.0, "-3.0f"), (1e-6, "1e-6f"), (1e-20, "1e-20f"),
     (0.1, "0.1f"), (3.141592653589793, "3.1415927f"), (1e10, "1e10f"), (1234567.0, "1.234567e6f")],
)  # fmt: skip
def test_readable(x, text):
    assert literal(x, suffix="f") == text


def test_what_does_not_fit_is_refused():
    with pytest.raises(EcfitError, match="does not fit"):
        literal(1e39)
