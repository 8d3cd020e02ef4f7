"""The method of Sforza & Pellacini 2022, rebuilt from the equations of the paper.

Tables: the integral of rho |mu_i| over phi in [0, 2 pi] and mu_i in [0, 1], or [-1, 0] in transmission, by
`scipy.integrate.dblquad` with its default tolerances over a compiled integrand. GGX, separable Smith G,
alpha = r^2, exact Fresnel, radiance transport. Fits: `scipy.optimize.curve_fit` of a ratio of polynomials
from all ones, with its own derivatives by finite differences.

Needs: pip install -e '.[bench]'
"""

import math
import warnings
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numba import cfunc, njit, types
from scipy import LowLevelCallable
from scipy.integrate import IntegrationWarning, dblquad
from scipy.optimize import curve_fit

Array = np.ndarray

# double f(int, double *, void *): what QUADPACK calls without entering Python.
C_SIGNATURE = types.double(types.intc, types.CPointer(types.double), types.voidptr)


@njit(fastmath=True)
def smith_g1(mu: float, a2: float) -> float:
    """GGX masking of one direction, a2 = alpha^2."""
    return 2.0 * mu / (mu + math.sqrt(a2 + (1.0 - a2) * mu * mu))


@njit(fastmath=True)
def fresnel(x: float, eta: float) -> float:
    """Exact unpolarised reflectance at x = wo.h; eta = n_transmitted / n_incident, as everywhere here."""
    g2 = eta * eta - 1.0 + x * x
    if g2 <= 0.0:
        return 1.0  # total internal reflection
    g = math.sqrt(g2)
    s, p = (g - x) / (g + x), (eta * eta * x - g) / (eta * eta * x + g)
    return 0.5 * (s * s + p * p)


@njit(fastmath=True)
def _conductor(mu_i: float, phi: float, mu_o: float, r: float, _eta: float) -> float:
    """Eq. 14 with rho = D G / (4 mu_o mu_i) (eq. 15)."""
    a2 = r * r * r * r
    s_o, s_i = math.sqrt(1.0 - mu_o * mu_o), math.sqrt(1.0 - mu_i * mu_i)
    x, y, z = s_o + s_i * math.cos(phi), s_i * math.sin(phi), mu_o + mu_i
    # sin^2 + alpha^2 cos^2 of theta_h, from wo + wi = (x, y, z).
    t2 = x * x + y * y
    d = (t2 + a2 * z * z) / (t2 + z * z)
    return a2 / (math.pi * d * d) * smith_g1(mu_o, a2) * smith_g1(mu_i, a2) / (4.0 * mu_o)


@njit(fastmath=True)
def _reflection(mu_i: float, phi: float, mu_o: float, r: float, eta: float) -> float:
    """Eq. 17 (before the division by E_ss) and 20: the same with F(wo.h)."""
    cosine = math.sqrt((1.0 - mu_o * mu_o) * (1.0 - mu_i * mu_i)) * math.cos(phi) + mu_o * mu_i  # wo.wi
    x = math.sqrt(max(0.5 + 0.5 * cosine, 0.0))
    return fresnel(x, eta) * _conductor(mu_i, phi, mu_o, r, eta)


@njit(fastmath=True)
def _transmission(mu_i: float, phi: float, mu_o: float, r: float, eta: float) -> float:
    """Eq. 21 with rho of eq. 23 (without eta^2: radiance transport)."""
    a2 = r * r * r * r
    s_o, s_i = math.sqrt(1.0 - mu_o * mu_o), math.sqrt(1.0 - mu_i * mu_i)
    x, y, z = s_o + eta * s_i * math.cos(phi), eta * s_i * math.sin(phi), mu_o + eta * mu_i
    # h is +-(x, y, z) = +-(wo + eta wi), the sign such that h.n > 0.
    t2 = x * x + y * y
    n2 = t2 + z * z
    cosine = s_o * s_i * math.cos(phi) + mu_o * mu_i  # wo.wi
    scale = math.copysign(1.0, z) / math.sqrt(n2)
    o_h, i_h = scale * (1.0 + eta * cosine), scale * (cosine + eta)
    if o_h <= 0.0 or i_h >= 0.0:
        return 0.0  # no refraction connects wo and wi
    d = (t2 + a2 * z * z) / n2
    g = smith_g1(mu_o, a2) * smith_g1(-mu_i, a2)
    return -i_h * o_h * (1.0 - fresnel(o_h, eta)) * a2 / (math.pi * d * d) * g / (mu_o * n2)


class Integral:
    """A double integral over mu_i in [low, low + 1] and phi in [0, 2 pi], compiled for both orders."""

    def __init__(self, integrand: Callable[..., float], low: float) -> None:
        # Compiled calls from C are about ten times faster than `njit` functions called through Python.
        @cfunc(C_SIGNATURE, fastmath=True)
        def mu_inside(_count: int, v: Any, _data: Any) -> float:
            return integrand(v[0], v[1], v[2], v[3], v[4])

        @cfunc(C_SIGNATURE, fastmath=True)
        def phi_inside(_count: int, v: Any, _data: Any) -> float:
            return integrand(v[1], v[0], v[2], v[3], v[4])

        phi, mu = (0.0, 2.0 * math.pi), (low, low + 1.0)
        self.orders = {
            "mu_i inside": (LowLevelCallable(mu_inside.ctypes), (*phi, *mu)),
            "phi inside": (LowLevelCallable(phi_inside.ctypes), (*mu, *phi)),
        }

    def __call__(self, mu: float, r: float, eta: float, order: str) -> float:
        function, limits = self.orders[order]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", IntegrationWarning)
            return dblquad(function, *limits, args=(mu, r, eta))[0]


# The order of eq. 12 first; the other is the same integral, which QUADPACK mostly does faster.
ORDERS = ("mu_i inside", "phi inside")

_conductor_albedo = Integral(_conductor, 0.0)
# Albedos of one lobe as functions of (mu, r, eta, order).
reflection = Integral(_reflection, 0.0)
transmission = Integral(_transmission, -1.0)


def albedo(mu: float, r: float, order: str) -> float:
    """The conductor's E at one point with the integrals nested as one of `ORDERS` says."""
    return _conductor_albedo(mu, r, math.inf, order)


def monomials(variables: int, degree: int) -> list[tuple[int, ...]]:
    """Exponents of all products of powers up to a total degree, the constant first."""
    found = (e for e in product(range(degree + 1), repeat=variables) if sum(e) <= degree)
    return sorted(found, key=sum)


class Fitted(NamedTuple):
    """What `fit` found: its values at the points, evaluations of all rows, and whether it ended by itself."""

    values: Array
    evaluations: int
    ended: bool


def fit(points: Sequence[Array], values: Array, method: str, most: int, degree: int = 3) -> Fitted:
    """P / Q of a degree in the coordinates `points`, fitted to `values` by `curve_fit` from all ones.

    Args:
        points: coordinates of all rows, one array a variable.
        values: of the table.
        method: of `curve_fit`: "lm" (its default: MINPACK) or "trf".
        most: Jacobians that are computed at most, by finite differences.
        degree: of P and Q; the constant of Q is 1.
    """
    exponents = monomials(len(points), degree)
    # Computed once for all of the solver's evaluations: its cheapest possible residual.
    basis = np.stack([np.prod([x**e for x, e in zip(points, row, strict=True)], axis=0) for row in exponents])
    terms = len(exponents)
    seen: list[Array] = []

    def rational(_: Array, *coefficients: float) -> Array:
        c = np.array(coefficients)
        seen.append(c)
        return (c[:terms] @ basis) / (1.0 + c[terms:] @ basis[1:])

    start = np.ones(2 * terms - 1)
    # MINPACK counts every evaluation for a Jacobian, `trf` none of them.
    limit: dict[str, Any] = {"maxfev": most * (start.size + 1)} if method == "lm" else {"max_nfev": most}
    try:
        found = curve_fit(rational, points[0], values, p0=start, method=method, **limit)[0]
        return Fitted(rational(points[0], *found), len(seen), True)
    except RuntimeError:  # the limit was reached: the best of the last two steps counts
        count, last = len(seen), seen[-2 * (start.size + 1) :]
        tried = (rational(points[0], *c) for c in last)
        return Fitted(min(tried, key=lambda v: float(np.sum(np.square(v - values)))), count, False)
