"""E_m,avg of height-correlated GGX as a Chebyshev series in r: the integral to 1e-10, at no cost.

Every exact albedo of the model contains this number of the roughness alone. Integrating it anew for every
direction would be the larger part of the work.
"""

from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np

from ecfit._jax import jax, jnp
from ecfit.files import read_json, write_json

Array = jax.Array

_DEGREE = 39


def _path() -> Path:
    return Path(str(resources.files("ecfit"))) / "data" / "enterprise" / "average.json"


@cache
def _series() -> np.ndarray:
    return np.asarray(read_json(_path())["chebyshev"], dtype=np.float64)


def white_average(alpha: Array) -> Array:
    """E_m,avg at GGX width alpha in [0, 1]: the sum of c_k T_k(2 r - 1), r = sqrt(alpha)."""
    series = _series()
    # The root's derivative at alpha = 0 is infinite, that of the sum is not.
    x = 2.0 * jnp.sqrt(jnp.maximum(alpha, 1e-30)) - 1.0
    b1, b2 = jnp.zeros_like(x), jnp.zeros_like(x)
    for c in series[:0:-1]:  # Clenshaw's recurrence
        b1, b2 = c + 2.0 * x * b1 - b2, b1
    return series[0] + x * b1 - b2


def integrate_series() -> np.ndarray:
    """The coefficients from the integrals at Chebyshev nodes of r; shape (degree + 1,)."""
    from ecfit.bsdf import model
    from ecfit.enterprise.energies import MASKING
    from ecfit.tables import tabulate

    t = np.cos(np.pi * (np.arange(_DEGREE + 1)[::-1] + 0.5) / (_DEGREE + 1))
    table = tabulate(
        model("conductor", masking=MASKING),
        {"r": 0.5 * (1.0 + t)},
        quantity="average-albedo",
        tolerance=1e-9,
    )
    return np.polynomial.chebyshev.chebfit(t, table.values, _DEGREE)


def write_series() -> None:
    """Integrate the series again: `python -m ecfit.enterprise.average`."""
    found = [float(f"{c:.13e}") for c in integrate_series()]
    write_json(_path(), {"of": "E_m,avg, GGX, height-correlated, in T_k(2 r - 1)", "chebyshev": found})


if __name__ == "__main__":
    write_series()
