"""C and C++ compile without a warning and compute what the expression says, bit for bit where IEEE does."""

import numpy as np
import pytest

from ecfit.approximation import find, published_names, shipped
from ecfit.errors import EcfitError
from ecfit.export import code
from ecfit.export.code import default_name, expression
from ecfit.export.compiled import compiled, compiler
from ecfit.export.coordinates import arguments
from ecfit.export.ulps import exact, points, ulps
from ecfit.expressions.evaluate import value
from ecfit.expressions.node import topological

needs = {s: pytest.mark.skipif(compiler(s) is None, reason=f"no compiler for {s}") for s in ("c99", "c++17")}
LANGUAGE = {"c99": "c", "c11": "c", "c++17": "cpp"}
# Functions of the C library differ from NumPy's by a few ulps; + - * / and roots round alike everywhere.
LIBRARY = {"exp", "exp2", "log", "pow"}

NAMES = [*shipped(), *published_names()]


@pytest.fixture(scope="module", params=[pytest.param(s, marks=m) for s, m in needs.items()])
def functions(request):
    """All fits in one library: one run of the compiler."""
    target = LANGUAGE[request.param]
    sources = [code(find(name), target) for name in NAMES]
    names = [(default_name(find(name)), len(find(name).variables)) for name in NAMES]
    return dict(zip(NAMES, compiled(sources, names, request.param), strict=True))


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


@pytest.mark.skipif(compiler("c11") is None, reason="no C compiler")
def test_a_warning_is_refused():
    bad = "static inline float f(float x) { const double y = 0.1; return x * y; }"
    with pytest.raises(EcfitError, match="refuses the exported code"):
        compiled([bad], [("f", 1)], "c11")


@pytest.mark.skipif(compiler("c11") is None, reason="no C compiler")
@pytest.mark.parametrize("views", [("r",), ("r", "ior"), ("alpha", "ior")])
def test_coordinates_inside(views):
    """The same surface in other coordinates has the same value; at the corners too it is a number."""
    fit = shipped("dielectric-entering-20")
    taken = arguments(fit, views, False)
    (function,) = compiled([code(fit, "c", name="E", coordinates=views)], [("E", 3)], "c11")
    at = points(taken, 2000, seed=4)
    found = function(*at.values())
    truth = np.asarray(fit(**{n: p.astype(np.float64) for n, p in at.items()}))
    assert taken.names == ("mu", *views) if "r" in views and len(views) == 2 else True
    assert np.all(np.isfinite(found))
    assert np.abs(found - truth).max() < 3e-6


@pytest.mark.skipif(compiler("c11") is None, reason="no C compiler")
def test_clamped_arguments_give_the_value_at_the_nearest_end():
    fit = shipped("dielectric-entering-20")
    (function,) = compiled([code(fit, "c", name="E", clamp=True)], [("E", 3)], "c11")
    low, high = fit.domain[2]
    mu, alpha, F0 = np.meshgrid([-0.5, 0.3, 1.5], [-1.0, 0.4, 7.0], [0.0, 0.1, 1.0])
    found = function(mu, alpha, F0)
    ends = [np.clip(mu, 0, 1), np.clip(alpha, 0, 1), np.clip(F0, low, high)]
    truth = np.asarray(fit(mu=ends[0], alpha=ends[1], F0=ends[2]))
    np.testing.assert_allclose(found, truth, atol=2e-6)
