"""One-dimensional rules on [0, 1]."""

from functools import lru_cache

import numpy as np


@lru_cache(maxsize=None)
def gauss_legendre(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1]: exact for polynomials of degree 2 count - 1."""
    x, w = np.polynomial.legendre.leggauss(count)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    x.setflags(write=False)
    w.setflags(write=False)
    return x, w


@lru_cache(maxsize=None)
def graded(depth: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre with `count` nodes on each of the panels [0, 2^-depth], ..., [1/4, 1/2], [1/2, 1].

    The dyadic panels resolve a peak at 0 whose width is about 2^-depth or more.
    """
    edges = np.concatenate([[0.0], 0.5 ** np.arange(depth, -1, -1)])
    x, w = gauss_legendre(count)
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * x).ravel(), (width * w).ravel()
