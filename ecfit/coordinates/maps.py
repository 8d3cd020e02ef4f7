"""Invertible named maps of one coordinate. Only arithmetic, so that NumPy and JAX arrays both pass."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Array = Any


@dataclass(frozen=True)
class Map:
    """An increasing map y = forward(x) on [low, high], with its inverse x = inverse(y).

    `formula` and `inverse_formula` say both in text, as `ecfit.expressions.parse` reads it.
    """

    name: str
    forward: Callable[[Array], Array]
    inverse: Callable[[Array], Array]
    low: float
    high: float
    formula: str
    inverse_formula: str


def _ior_from_f0(f0: Array) -> Array:
    s = np.float64(1.0) * f0**0.5
    with np.errstate(divide="ignore"):  # F0 = 1 is an infinite index
        return (1.0 + s) / (1.0 - s)


def _f0_from_ior(ior: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        e = np.float64(1.0) / ior
        s = (1.0 - e) / (1.0 + e)
    return s * s


_INFINITY = float("inf")

MAPS: dict[str, Map] = {
    m.name: m
    for m in (
        Map("identity", lambda x: x, lambda y: y, -_INFINITY, _INFINITY, "y = x", "x = y"),
        Map("square", lambda x: x * x, lambda y: y**0.5, 0.0, _INFINITY, "y = x^2", "x = sqrt(y)"),
        Map("sqrt", lambda x: x**0.5, lambda y: y * y, 0.0, _INFINITY, "y = sqrt(x)", "x = y^2"),
        Map("fourth-power", lambda x: (x * x) * (x * x), lambda y: y**0.25, 0.0, _INFINITY,
            "y = x^4", "x = sqrt(sqrt(y))"),
        # Normal-incidence reflectance of a dielectric interface in air.
        Map("F0-to-ior", _ior_from_f0, _f0_from_ior, 0.0, 1.0,
            "y = (1 + sqrt(x)) / (1 - sqrt(x))", "x = ((y - 1) / (y + 1))^2"),
    )
}  # fmt: skip
