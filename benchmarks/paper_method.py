"""The method of Sforza & Pellacini 2022, rebuilt from the equations of the paper.

Tables: E(mu_o) = integral of rho mu_i over phi in [0, 2 pi] and mu_i in [0, 1] (eq. 12 and 14, F = 1), with
rho = D G / (4 mu_o mu_i) (eq. 15), GGX, separable Smith G and alpha = r^2, by `scipy.integrate.dblquad`
with its default tolerances over a compiled integrand. Fits: `scipy.optimize.curve_fit` of a ratio of
polynomials from all ones.

Needs: pip install -e '.[bench]'
"""

import math
import warnings
from typing import Any

import numpy as np
from numba import cfunc, njit, types
from scipy import LowLevelCallable
from scipy.integrate import IntegrationWarning, dblquad
from scipy.optimize import curve_fit

Array = np.ndarray

# double f(int, double *, void *): what QUADPACK calls without entering Python.
C_SIGNATURE = types.double(types.intc, types.CPointer(types.double), types.voidptr)

# Exponents of r and mu.
MONOMIALS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))


@njit(fastmath=True)
def smith_g1(mu: float, a2: float) -> float:
    """GGX masking of one direction, a2 = alpha^2."""
    return 2.0 * mu / (mu + math.sqrt(a2 + (1.0 - a2) * mu * mu))


@njit(fastmath=True)
def _integrand(mu_i: float, phi: float, mu_o: float, r: float) -> float:
    a2 = r * r * r * r
    s_o, s_i = math.sqrt(1.0 - mu_o * mu_o), math.sqrt(1.0 - mu_i * mu_i)
    x, y, z = s_o + s_i * math.cos(phi), s_i * math.sin(phi), mu_o + mu_i
    # sin^2 + alpha^2 cos^2 of theta_h, from wo + wi = (x, y, z).
    t2 = x * x + y * y
    d = (t2 + a2 * z * z) / (t2 + z * z)
    return a2 / (math.pi * d * d) * smith_g1(mu_o, a2) * smith_g1(mu_i, a2) / (4.0 * mu_o)


# Compiled calls from C are about ten times faster than `njit` functions called through Python.
@cfunc(C_SIGNATURE, fastmath=True)
def _mu_inside(_count: int, v: Any, _data: Any) -> float:
    return _integrand(v[0], v[1], v[2], v[3])


@cfunc(C_SIGNATURE, fastmath=True)
def _phi_inside(_count: int, v: Any, _data: Any) -> float:
    return _integrand(v[1], v[0], v[2], v[3])


_PHI, _MU = (0.0, 2.0 * math.pi), (0.0, 1.0)
# The order of eq. 12 first; the other is the same integral, which QUADPACK does faster.
ORDERS = {
    "mu_i inside": (LowLevelCallable(_mu_inside.ctypes), (*_PHI, *_MU)),
    "phi inside": (LowLevelCallable(_phi_inside.ctypes), (*_MU, *_PHI)),
}


def albedo(mu: float, r: float, order: str) -> float:
    """E at one point with the integrals nested as one of `ORDERS` says."""
    function, limits = ORDERS[order]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", IntegrationWarning)
        return dblquad(function, *limits, args=(mu, r))[0]


def fit(r: Array, mu: Array, values: Array) -> Array:
    """P / Q of degree 3 in (r, mu), evaluated at the given points, fitted to `values`.

    10 coefficients of P, 9 of Q beside its constant 1.
    """
    # Computed once for all of the solver's evaluations: its cheapest possible residual.
    basis = np.stack([r**i * mu**j for i, j in MONOMIALS])
    terms = len(MONOMIALS)

    def rational(_: Array, *coefficients: float) -> Array:
        c = np.array(coefficients)
        return (c[:terms] @ basis) / (1.0 + c[terms:] @ basis[1:])

    found = curve_fit(rational, r, values, p0=np.ones(2 * terms - 1), method="trf")[0]
    return rational(r, *found)
