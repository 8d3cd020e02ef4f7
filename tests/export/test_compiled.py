"""C and C++ compile without a warning and compute what the expression says, bit for bit where IEEE does."""

import numpy as np
import pytest

from ecfit.approximation import find, published_names, shipped
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError
from ecfit.export import code
from ecfit.export.code import default_name, expression
from ecfit.export.compiled import compiled
from ecfit.export.compilers import CC, CXX
from ecfit.export.coordinates import arguments
from ecfit.export.ulps import exact, points, ulps
from ecfit.expressions.evaluate import value
from ecfit.expressions.node import topological

needs_c = pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))
needs_cpp = pytest.mark.skipif(CXX.missing() is not None, reason=str(CXX.missing()))
LANGUAGE = {"c99": "c", "c11": "c", "c++17": "cpp"}
# Functions of the C library differ from NumPy's by a few ulps; + - * / and roots round alike everywhere.
LIBRARY = {"exp", "exp2", "log", "pow"}

NAMES = [*shipped(), *published_names()]


def library(standard: str, names: list[str]):
    """Fits in one library: one run of the compiler."""
    fits = [find(name) for name in names]
    sources = [code(fit, LANGUAGE[standard]) for fit in fits]
    functions = [(default_name(fit), len(fit.variables)) for fit in fits]
    return dict(zip(names, compiled(sources, functions, standard), strict=True))


@pytest.fixture(scope="module")
def functions():
    return library("c99", NAMES)


@needs_c
@pytest.mark.parametrize("name", NAMES)
def test_every_fit_computes_what_its_expression_says(functions, name):
    fit = find(name)
    taken = arguments(fit, (), False)
    node = expression(fit, taken)
    at = points(taken, 3000, seed=1)
    found = functions[name](*at.values())
    assert np.all(np.isfinite(found))
    reference = np.asarray(value(node, at))
    if LIBRARY.isdisjoint(n.op for n in topological([node])):
        np.testing.assert_array_equal(found, reference)
    else:
        np.testing.assert_allclose(found, reference, rtol=1e-4, atol=3e-6)


@needs_c
@pytest.mark.parametrize("name", shipped())
def test_shipped_fits_are_finite_and_near_the_model_everywhere(functions, name):
    """Against the approximation itself, in double precision: the export has not changed what it is."""
    fit = find(name)
    taken = arguments(fit, (), False)
    at = points(taken, 2000, seed=2)
    wide = {n: p.astype(np.float64) for n, p in at.items()}
    truth = fit.formula.value([wide[v] for v in fit.variables])
    assert np.abs(functions[name](*at.values()) - truth).max() < 1e-5
    inside = points(taken, 4000, seed=3, edges=False)
    off = ulps(functions[name](*inside.values()), exact(expression(fit, taken), inside))
    assert np.median(off) < 5.0


@needs_cpp
@pytest.mark.parametrize("names", [["conductor-10", "glossy-10", "karis-mobile"],
                                   pytest.param(NAMES, marks=pytest.mark.slow)])  # fmt: skip
def test_cpp_is_c(functions, names):
    for name, function in library("c++17", names).items():
        at = points(arguments(find(name), (), False), 500, seed=5).values()
        np.testing.assert_array_equal(function(*at), functions[name](*at))


@needs_c
def test_a_warning_is_refused():
    bad = "static inline float f(float x) { const double y = 0.1; return x * y; }"
    with pytest.raises(EcfitError, match="refuses the exported code"):
        compiled([bad], [("f", 1)], "c11")


def test_no_compiler_is_an_error_with_the_remedy(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler -O1")
    with pytest.raises(EcfitError, match="no cc: a C compiler .* or set CC"):
        compiled([], [], "c11")


@needs_c
@pytest.mark.parametrize("views", [("r",), ("r", "ior"), ("alpha", "ior")])
def test_coordinates_inside(views):
    """The same surface in other coordinates has the same value; at the corners too it is a number."""
    fit = shipped("dielectric-entering-20")
    taken = arguments(fit, views, False)
    (function,) = compiled([code(fit, "c", name="E", coordinates=views)], [("E", 3)], "c11")
    at = points(taken, 2000, seed=4)
    found = function(*at.values())
    wide = {n: p.astype(np.float64) for n, p in at.items()}
    inside = resolve(fit.variables, wide)
    truth = fit.formula.value([inside[v] for v in fit.variables])
    assert set(views) <= set(taken.names)
    assert np.all(np.isfinite(found))
    assert np.abs(found - truth).max() < 3e-6


@needs_c
def test_clamped_arguments_give_the_value_at_the_nearest_end():
    fit = shipped("dielectric-entering-20")
    (function,) = compiled([code(fit, "c", name="E", clamp=True)], [("E", 3)], "c11")
    low, high = fit.domain[2]
    mu, alpha, F0 = np.meshgrid([-0.5, 0.3, 1.5], [-1.0, 0.4, 7.0], [0.0, 0.1, 1.0])
    found = function(mu, alpha, F0)
    ends = [np.clip(mu, 0, 1), np.clip(alpha, 0, 1), np.clip(F0, low, high)]
    truth = fit.formula.value(ends)
    np.testing.assert_allclose(found, truth, atol=2e-6)
