"""Every shipped fit in each language, compiled and run as one program; slow: published formulas too.

Tools that are not there skip, with what to install.
"""

import os
from functools import cache

import numpy as np
import pytest

from ecfit.approximation import find, published_names, shipped
from ecfit.errors import EcfitError
from ecfit.expressions.node import topological
from ecfit.shaders.cases import case, family
from ecfit.shaders.check import compare
from ecfit.shaders.devices import NoDevice
from ecfit.shaders.tools import TOOLS

POINTS = 2048
# Compiled C, C++, Metal as C++, Slang and OSL round each operation as NumPy does. Mesa's compiler rewrites
# sums, products and quotients, as shading languages allow: that may cost what NumPy loses once more.
BIT_EXACT = {"cc", "c++", "c-as-c++", "metal-as-c++", "slang", "cycles"}
AGAIN = 2.0
# Functions of other libraries, which differ from NumPy's by a few ulps.
LIBRARY = {"exp", "exp2", "log", "pow"}
# Of 1: what two right roundings may differ by where NumPy happens to be exact.
ULP = 2.0**-23

FAST = ["metal-as-c++", "opengl", "opengl-es", "webgpu"]
SLOW = [n for n in TOOLS if n not in FAST and TOOLS[n].device is not None]


def slow(names):
    return [pytest.param(n, marks=pytest.mark.slow) for n in names]


@cache
def cases(names, language):
    """Those that are formulas of up to four coordinates, not tables."""
    found = []
    for name in names:
        try:
            found.append(case(find(name), language))
        except EcfitError:
            continue
    return found


def run(name, formulas):
    tool = TOOLS[name]
    if tool.missing():
        pytest.skip(str(tool.missing()))
    given = cases(formulas, tool.language)
    try:
        found = compare(given, tool, POINTS).agreements
    except NoDevice as reason:
        pytest.skip(str(reason))
    assert len(found) == len(given) > 30
    for one, that in zip(given, found, strict=True):
        assert that.not_finite == that.unknown == 0, that.describe()
        if name in BIT_EXACT and LIBRARY.isdisjoint(n.op for n in topological([one.expression])):
            assert that.worst == 0.0, that.describe()
        assert that.error <= AGAIN * that.numpy_error + ULP, that.describe()


@pytest.mark.parametrize("name", [*FAST, *slow(SLOW)])
def test_shipped_fits_are_finite_and_as_exact_as_in_numpy(name):
    run(name, tuple(shipped()))


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FAST, *SLOW])
def test_published_formulas_are_finite_and_as_exact_as_in_numpy(name):
    run(name, tuple(published_names()))


@pytest.mark.parametrize("name", ["glslang", "glslang-hlsl", "tint", *slow(n for n in TOOLS if "-to-" in n)])
def test_shipped_fits_compile(name):
    """Without a device: the compilers accept them, and valid SPIR-V or text comes out."""
    tool = TOOLS[name]
    missing = [s.compiler.missing() for s in tool.steps if s.compiler.missing()]
    if missing:
        pytest.skip(str(missing[0]))
    given = cases(tuple(shipped()), tool.language)
    made = tool.compile([c.function for c in given])
    assert len(made) > 300 * len(given)
    if name in ("glslang", "glslang-hlsl"):
        assert made.startswith(b"\x03\x02\x23\x07")
    if name == "slang-to-metal":
        assert b"#include <metal_stdlib>" in made


@pytest.mark.parametrize("name", ["metal-as-c++", "opengl", *slow(n for n in [*FAST[2:], *SLOW])])
def test_factors_and_slopes(name):
    """What a lobe is multiplied with, a metal's in colour, and the derivative, from one file."""
    tool = TOOLS[name]
    if tool.missing():
        pytest.skip(str(tool.missing()))
    given = family(shipped("conductor-10"), tool.language, "alpha")
    try:
        found = compare(given, tool, POINTS).agreements
    except NoDevice as reason:
        pytest.skip(str(reason))
    value, factor, metal, slope = found
    assert [a.name for a in found] == [
        "conductor_10",
        *(f"conductor_10_{n}" for n in ("factor", "metal", "dalpha")),
    ]
    for one in (value, factor, metal):
        assert one.passes, one.describe()
    assert slope.not_finite == slope.unknown == 0, slope.describe()
    # Near alpha = mu = 0 it is steep and loses digits.
    assert slope.exact_common < 64.0, slope.describe()
    if name in BIT_EXACT:
        assert max(a.worst for a in found) == 0.0, slope.describe()


@pytest.mark.slow
@pytest.mark.skipif(
    not os.environ.get("ECFIT_BPY_PYTHON"), reason="set ECFIT_BPY_PYTHON to a Python with bpy"
)
def test_blender_refuses_what_is_no_osl():
    from ecfit.shaders.program import Function

    wrong = Function("f", 1, "float f(float x) { return x }")
    with pytest.raises(EcfitError, match="refuses the shader"):
        TOOLS["cycles"].run([wrong], np.zeros((1, 4, 4), dtype=np.float32))
