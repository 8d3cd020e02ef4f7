"""The conductor's directional albedo to better than 1e-12, independently of ecfit.

Adaptive integration over directions of light (ecfit integrates over half vectors), with what the plain
method lacks: no cancellation next to the mirror direction, and panels that shrink towards it.
"""

import math
import warnings
from typing import Any

import numpy as np
import paper_method
from numba import cfunc
from scipy import LowLevelCallable
from scipy.integrate import IntegrationWarning, nquad

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
