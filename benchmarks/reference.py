"""True directional albedos, independently of ecfit: none of its code, other coordinates.

Conductor, to better than 1e-12: adaptive integration over directions of light (ecfit integrates over half
vectors), with what the plain method lacks: no cancellation next to the mirror direction, and panels that
shrink towards it.

Lobes with exact dielectric Fresnel, to better than 1e-12 for mu >= 1e-3, r >= 0.03 and any ior >= 1, next to
the critical angle too: double-exponential rules over half vectors in polar coordinates around wo, where the
pole of ecfit's is the normal. The same integrals over directions, split at their edges, agree to 4e-13 where
alpha >= 0.01, and to their own tolerance, 1e-10, at r = 0.03.
"""

import math
import warnings
from typing import Any

import numpy as np
import paper_method
from numba import cfunc, njit
from scipy import LowLevelCallable
from scipy.integrate import IntegrationWarning, nquad

Array = np.ndarray

_TOLERANCE = {"epsabs": 1e-13, "epsrel": 1e-13, "limit": 500}
# Distances from the mirror direction and from the horizon where panels end.
_STEPS = 10.0 ** (-0.5 * np.arange(11))
_smith_g1 = paper_method.smith_g1


@cfunc(paper_method.C_SIGNATURE)
def _integrand(_count: int, v: Any, _data: Any) -> float:
    psi, theta_i, mu_o, r = v[0], v[1], v[2], v[3]  # psi: azimuth from the mirror direction
    a2 = r * r * r * r
    theta_o = math.acos(mu_o)
    s_i, mu_i = math.sin(theta_i), math.cos(theta_i)
    # s_i cos(psi) - s_o without cancellation.
    middle, difference = 0.5 * (theta_i + theta_o), 0.5 * (theta_i - theta_o)
    x = 2.0 * math.cos(middle) * math.sin(difference) - 2.0 * s_i * math.sin(0.5 * psi) ** 2
    y, z = s_i * math.sin(psi), mu_o + mu_i
    t2 = x * x + y * y
    d = (t2 + a2 * z * z) / (t2 + z * z)
    density = a2 / (math.pi * d * d) * _smith_g1(mu_o, a2) * _smith_g1(mu_i, a2) / (4.0 * mu_o)
    return density * s_i  # dmu_i = s_i dtheta_i


_COMPILED = LowLevelCallable(_integrand.ctypes)


def albedo(mu: float, r: float) -> float:
    """E at one point, for mu in (0, 1] and r > 0."""
    theta, top = math.acos(mu), 0.5 * math.pi
    ends = np.unique(np.concatenate([theta - _STEPS, [theta], theta + _STEPS, top - _STEPS]))
    options = [
        {**_TOLERANCE, "points": _STEPS.tolist()},
        {**_TOLERANCE, "points": ends[(ends > 0.0) & (ends < top)].tolist()},
    ]
    with warnings.catch_warnings():
        # The tolerance is at the limit of rounding: QUADPACK says so where it gets no further.
        warnings.simplefilter("ignore", IntegrationWarning)
        return 2.0 * nquad(_COMPILED, [[0.0, math.pi], [0.0, top]], args=(mu, r), opts=options)[0]


# Half vectors in polar coordinates around wo: beta is the angle from wo, x = wo.h = cos(beta), and chi the
# azimuth from the side of the normal. F and total internal reflection depend on beta alone, D and G2 on h.n
# as well; every edge of the domain has a closed form. With v = 1 - h.n, exact at the peak of D,
#   E = integral of (F or 1 - F) x D(h) G2(wo, wi) / mu_o over sin(beta) dbeta dchi,
#   v = 2 sin^2((theta_o - beta) / 2) + 2 sin(theta_o) sin(beta) sin^2(chi / 2).


@njit
def _fresnel(x: float, eta: float) -> tuple[float, float]:
    """F (1 under total internal reflection) and g = eta cos(theta_t) at a microfacet."""
    if math.isinf(eta):
        return 1.0, math.inf
    g2 = (eta - 1.0) * (eta + 1.0) + x * x
    if g2 <= 0.0:
        return 1.0, 0.0
    g, n2 = math.sqrt(g2), eta * eta
    s, p = (g - x) / (g + x), (n2 * x - g) / (n2 * x + g)
    return 0.5 * (s * s + p * p), g


@njit
def _azimuth(v: float, v0: float, width: float) -> float:
    """chi in [0, pi] where 1 - h.n = v, or the end of the range nearest to it."""
    if v <= v0:
        return 0.0
    return math.pi if v >= v0 + width else 2.0 * math.asin(math.sqrt((v - v0) / width))


@njit
def _ring(
    beta: float, mu: float, a2: float, eta: float, reflects: bool, separable: bool, rule: Array
) -> float:
    """The integral over chi at one beta, for both signs of chi."""
    theta, x = math.acos(mu), max(math.cos(beta), 1e-300)
    fresnel, g = _fresnel(x, eta)
    factor = fresnel if reflects else 1.0 - fresnel
    if factor <= 0.0:
        return 0.0
    v0 = 2.0 * math.sin(0.5 * (theta - beta)) ** 2
    width = 2.0 * math.sin(theta) * math.sin(beta)
    # h.n > 0, and cos(theta_i) = 2 x h.n - mu > 0 in reflection.
    end = _azimuth(1.0 - mu / (2.0 * x) if reflects else 1.0, v0, width)
    # |cos(theta_i)| = (mu + (g - x) h.n) / eta > 0 in transmission.
    start = _azimuth(1.0 - mu / (x - g), v0, width) if g < x and not reflects else 0.0
    m_o = 0.5 * (mu + math.sqrt(a2 + (1.0 - a2) * mu * mu))  # mu / G1
    total = 0.0
    for near, weight in rule:
        for chi in (start + (end - start) * near, end - (end - start) * near):
            v = v0 + width * math.sin(0.5 * chi) ** 2
            z = 1.0 - v
            d = v * (2.0 - v) + a2 * z * z
            mu_i = max(2.0 * x * z - mu if reflects else (mu + (g - x) * z) / eta, 0.0)
            m_i = 0.5 * (mu_i + math.sqrt(a2 + (1.0 - a2) * mu_i * mu_i))
            # G2 / (mu_o mu_i)
            inverse = m_o * m_i if separable else m_o * mu_i + mu * m_i - mu * mu_i
            total += weight * mu_i / (inverse * d * d)
    return 2.0 * (end - start) * total * a2 / math.pi * factor * x * math.sin(beta)


@njit
def _integral(
    ends: Array, mu: float, a2: float, eta: float, reflects: bool, separable: bool, rule: Array
) -> float:
    total = 0.0
    for k in range(ends.size - 1):
        low, high = ends[k], ends[k + 1]
        for near, weight in rule:
            for beta in (low + (high - low) * near, high - (high - low) * near):
                total += weight * (high - low) * _ring(beta, mu, a2, eta, reflects, separable, rule)
    return total


def _double_exponential(level: int) -> Array:
    """Rows of distance to the nearer end of [0, 1] and weight (Takahasi & Mori 1974), with step 2^-level.

    Whatever the integrand does at the ends (square-root edges, peaks as narrow as alpha), halving the step
    about doubles the number of digits.
    """
    t = np.arange(0.0, 3.2, 0.5**level)
    e = np.exp(-np.pi * np.sinh(t))
    weights = 0.5**level * np.pi * np.cosh(t) * e / (1.0 + e) ** 2
    weights[0] *= 0.5  # the middle counts from both ends
    return np.stack([e / (1.0 + e), weights], axis=1)


_RULES = [_double_exponential(level) for level in range(4, 9)]


def _lobe(mu: float, r: float, eta: float, reflects: bool, masking: str) -> float:
    """Energy of one lobe: the step is halved until that changes nothing."""
    theta, right = math.acos(mu), 0.5 * math.pi
    critical = math.asin(min(eta, 1.0))
    # wi on the horizon at chi = pi and at chi = 0; in transmission at chi = 0, and h at chi = pi.
    grazing = math.atan2(eta * mu, 1.0 - eta * math.sin(theta)) if eta < 1.0 else right
    horizons = (0.5 * (right - theta), 0.5 * (right + theta)) if reflects else (right - theta, grazing)
    top = horizons[1] if reflects else critical
    separable = {"separable": True, "height-correlated": False}[masking]
    ends = np.unique([e for e in (0.0, theta, critical, *horizons, top) if e <= top])
    value = math.inf
    for rule in _RULES:
        last = value
        value = _integral(ends, mu, r**4, eta, reflects, separable, rule)
        if abs(value - last) < 1e-10:
            return value
    raise ArithmeticError(f"no convergence at mu = {mu}, r = {r}, eta = {eta}")


def dielectric(
    mu: float, r: float, ior: float, side: str = "entering", masking: str = "separable"
) -> tuple[float, float]:
    """(R, T) of a rough dielectric in energy transport, with exact Fresnel, seen from one side.

    T in radiance transport is this divided by eta^2 (eta = ior entering, 1 / ior leaving).
    """
    eta = {"entering": ior, "leaving": 1.0 / ior}[side]
    return _lobe(mu, r, eta, True, masking), _lobe(mu, r, eta, False, masking)


def reflection(mu: float, r: float, ior: float, masking: str = "separable") -> float:
    """The reflected lobe seen from outside: E_F of a glossy layer; E_ss at ior = infinity, where F = 1."""
    return _lobe(mu, r, ior, True, masking)
