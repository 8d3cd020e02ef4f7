"""What the tests share: strict JAX, repeatable hypothesis, a guard against hangs, tables computed once.

Reference integrals here use NumPy only and none of ecfit's rules, maps or formulas.
"""

import itertools
import math
import signal
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import ecfit
from ecfit._jax import jax
from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.tables import Table

# Mixing float32 into float64, or integers into floats, is a mistake in numerical code that JAX else hides.
jax.config.update("jax_numpy_dtype_promotion", "strict")

# Derandomised: a failure in CI is a failure here. `--hypothesis-profile explore` looks further.
settings.register_profile("repeatable", deadline=None, derandomize=True, max_examples=100)
settings.register_profile("explore", deadline=None, max_examples=3000)
settings.load_profile("repeatable")


def gauss_panels(edges: Sequence[float] | np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of Gauss-Legendre with `count` nodes on each panel between `edges`."""
    x, w = np.polynomial.legendre.leggauss(count)
    low, width = np.asarray(edges)[:-1, None], np.diff(edges)[:, None]
    return (low + width * 0.5 * (x + 1.0)).ravel(), (width * 0.5 * w).ravel()


def graded_edges(points: Sequence[float], depth: int) -> np.ndarray:
    """Edges of panels that halve `depth` times towards each of the increasing `points`."""
    near = 0.5 ** np.arange(1, depth + 1)
    pieces = [np.asarray(points, dtype=float)]
    for low, high in itertools.pairwise(points):
        pieces += [low + (high - low) * near, high - (high - low) * near]
    return np.unique(np.concatenate(pieces))


_erfc = np.vectorize(math.erfc)


def smith_lambda(ndf: str, mu: Any, alpha: float) -> np.ndarray:
    """Smith's Lambda in the textbook form (Walter et al. 2007, eq. 34; Heitz 2014, eq. 72)."""
    mu = np.asarray(mu, dtype=float)
    tan = np.sqrt(1.0 - mu * mu) / mu
    if ndf == "ggx":
        return 0.5 * (np.sqrt(1.0 + (alpha * tan) ** 2) - 1.0)
    a = 1.0 / (alpha * np.maximum(tan, 1e-300))
    a = np.minimum(a, 26.0)
    return np.exp(-a * a) / (2.0 * a * np.sqrt(np.pi)) - 0.5 * _erfc(a)


def normals(ndf: str, cos: np.ndarray, alpha: float) -> np.ndarray:
    """D in the textbook form (Walter et al. 2007, eq. 25 and 33)."""
    tan2 = (1.0 - cos * cos) / (cos * cos)
    if ndf == "ggx":
        return 1.0 / (np.pi * alpha**2 * cos**4 * (1.0 + tan2 / alpha**2) ** 2)
    return np.exp(-tan2 / alpha**2) / (np.pi * alpha**2 * cos**4)


def albedo_over_directions(
    ndf: str, masking: str, mu: float, alpha: float, fresnel: Callable[[np.ndarray], Any] = np.ones_like
) -> float:
    """E by integration over directions of light, on panels graded towards the mirror direction."""
    theta_o = math.acos(mu)
    ends = [0.0, theta_o, 0.5 * math.pi] if theta_o > 0.0 else [0.0, 0.5 * math.pi]
    theta, w_theta = gauss_panels(graded_edges(ends, 10), 22)
    # The azimuth from the mirror direction; the integrand is even in it.
    phi, w_phi = gauss_panels(np.pi * np.r_[0.0, 0.5 ** np.arange(10, -1, -1)], 22)
    sin_i, mu_i = np.sin(theta)[:, None], np.cos(theta)[:, None]
    wo = np.array([-math.sin(theta_o), 0.0, mu])[:, None, None]
    wi = np.stack(np.broadcast_arrays(sin_i * np.cos(phi), sin_i * np.sin(phi), mu_i))
    h = wo + wi
    h = h / np.sqrt(np.sum(h * h, axis=0))
    l_o, l_i = smith_lambda(ndf, mu, alpha), smith_lambda(ndf, mu_i, alpha)
    g = 1.0 / ((1.0 + l_o) * (1.0 + l_i)) if masking == "separable" else 1.0 / (1.0 + l_o + l_i)
    f_cos = fresnel(np.sum(wo * h, axis=0)) * normals(ndf, h[2], alpha) * g / (4.0 * mu)
    return float(2.0 * (w_theta * np.sin(theta)) @ f_cos @ w_phi)


def synthetic_table(f: Callable[..., Any], *axes: Axis, tolerance: float = 1e-7) -> Table:
    """A table of a function of its axes' nominal coordinates."""
    mesh = np.meshgrid(*[a.nominal for a in axes], indexing="ij")
    values = np.broadcast_to(np.asarray(f(*mesh), dtype=float), mesh[0].shape)
    status = np.zeros(values.shape, dtype=np.int8)
    return Table(values, np.zeros(values.shape), status, axes, Contract("unknown"), tolerance)


@pytest.fixture(scope="session")
def panels() -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """`panels(points, depth, count)`: nodes and weights graded towards each of the points."""
    return lambda points, depth, count: gauss_panels(graded_edges(points, depth), count)


@pytest.fixture(scope="session")
def reference_albedo() -> Callable[..., float]:
    """`reference_albedo(ndf, masking, mu, alpha, fresnel)`, good to about 1e-13 for alpha >= 0.05."""
    return albedo_over_directions


@pytest.fixture(scope="session")
def reference_lambda() -> Callable[..., np.ndarray]:
    """`reference_lambda(ndf, mu, alpha)`."""
    return smith_lambda


@pytest.fixture(scope="session")
def make_table() -> Callable[..., Table]:
    """`make_table(f, *axes)`: a table of f on axes."""
    return synthetic_table


@pytest.fixture(scope="session")
def unit_axis() -> Callable[..., Axis]:
    """`unit_axis(name, count)`: uniform on [0, 1]."""
    return lambda name, count: Axis.spaced(name, count)


@pytest.fixture(scope="session")
def paper_table() -> Table:
    """The conductor on the clamped 32 x 32 axes of Sforza & Pellacini 2022."""
    r = Axis.spaced("r", 32, 0.035, 1.0, "clamped")
    mu = Axis.spaced("mu", 32, 0.02, 1.0, "clamped")
    return ecfit.tabulate("conductor", {"r": r, "mu": mu})


@pytest.fixture
def no_hang() -> Iterator[None]:
    """Turn an endless loop into a failure."""
    if not hasattr(signal, "SIGALRM"):  # Windows
        yield
        return

    def fail(*_: Any) -> None:
        raise TimeoutError("this test hangs")

    old = signal.signal(signal.SIGALRM, fail)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, old)
