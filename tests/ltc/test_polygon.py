"""Form factors of polygons, against integration over their area in NumPy."""

import itertools
import math

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError
from ecfit.ltc import lobe_share, polygon_share, stretched_cosine

SQUARE = np.array([[-1.0, -0.5, 2.0], [1.0, -0.5, 2.0], [1.0, 0.8, 1.5], [-1.0, 0.8, 1.5]])
TILTED = np.array([[0.5, -1.0, -0.6], [1.2, 0.9, -0.2], [0.4, 1.1, 1.3], [0.1, -0.4, 0.9]])


def flat(polygon):
    """The polygon's corners moved into the plane of the first three."""
    n = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
    n /= np.linalg.norm(n)
    return polygon - np.outer((polygon - polygon[0]) @ n, n)


def above(polygon):
    """Sutherland and Hodgman's clipping at z = 0."""
    out = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if a[2] >= 0.0:
            out.append(a)
        if (a[2] >= 0.0) != (b[2] >= 0.0):
            out.append(a + (b - a) * (a[2] / (a[2] - b[2])))
    return np.array(out)


def over_area(polygon, density, cuts=4, count=16):
    """The integral of a density per steradian over a convex polygon above the horizon."""
    x, w = np.polynomial.legendre.leggauss(count)
    x = np.concatenate([(0.5 * (x + 1.0) + i) / cuts for i in range(cuts)])
    w = np.tile(0.5 * w / cuts, cuts)
    total = 0.0
    for b, c in itertools.pairwise(polygon[1:]):
        ab, bc = b - polygon[0], c - b
        normal = np.cross(ab, bc)
        p = polygon[0] + x[:, None, None] * (ab + x[None, :, None] * bc)
        r2 = np.sum(p * p, axis=-1)
        omega = np.abs(p @ normal) / r2**1.5 * x[:, None]
        total += w @ (density(p[..., 2] / np.sqrt(r2)) * omega) @ w
    return total


def cosine(mu):
    return mu / math.pi


@pytest.mark.parametrize("polygon", [SQUARE, flat(SQUARE[:3])])
def test_the_share_of_a_polygon_above_the_horizon(polygon):
    expected = over_area(polygon, cosine)
    assert float(polygon_share(polygon)) == pytest.approx(expected, abs=1e-12)
    assert float(polygon_share(polygon[::-1])) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("turn", range(4))
def test_a_polygon_that_sets_is_clipped(turn):
    """Whichever corner comes first: those below the horizon at the ends, or in the middle, of the list."""
    polygon = np.roll(flat(TILTED), turn, axis=0)
    expected = over_area(above(polygon), cosine)
    assert float(polygon_share(polygon)) == pytest.approx(expected, abs=1e-10)
    assert expected > 0.05


def test_a_triangle_with_one_corner_below_gains_a_corner():
    polygon = np.array([[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.3, -1.0]])
    assert len(above(polygon)) == 4
    assert float(polygon_share(polygon)) == pytest.approx(over_area(above(polygon), cosine), abs=1e-10)


def test_known_form_factors():
    big = 1e7
    ceiling = [[-big, -big, 1.0], [big, -big, 1.0], [big, big, 1.0], [-big, big, 1.0]]
    assert float(polygon_share(ceiling)) == pytest.approx(1.0, abs=1e-6)
    # A wall that covers half of the horizon: half of the light.
    wall = [[1.0, -big, -big], [1.0, big, -big], [1.0, big, big], [1.0, -big, big]]
    assert float(polygon_share(wall)) == pytest.approx(0.5, abs=1e-6)
    below = SQUARE * np.array([1.0, 1.0, -1.0])
    assert float(polygon_share(below)) == 0.0
    # Two walls that meet share one's light.
    left, right = (
        np.array([[1.0, a, -0.2], [1.0, b, -0.2], [1.0, b, 0.7], [1.0, a, 0.7]])
        for a, b in [(-0.3, 0.1), (0.1, 0.9)]
    )
    whole = np.array([[1.0, -0.3, -0.2], [1.0, 0.9, -0.2], [1.0, 0.9, 0.7], [1.0, -0.3, 0.7]])
    parts = float(polygon_share(left)) + float(polygon_share(right))
    assert parts == pytest.approx(float(polygon_share(whole)), abs=1e-14)


@pytest.mark.parametrize("scale", [0.6, 1.0, 3.0])
@pytest.mark.parametrize("polygon", [SQUARE, flat(TILTED)], ids=["above", "clipped"])
def test_the_share_of_a_transformed_cosine(polygon, scale):
    expected = over_area(above(polygon), lambda mu: np.asarray(stretched_cosine(mu, scale)), cuts=6)
    assert float(lobe_share(polygon, scale)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("scale", [0.5, 1.0, 4.0])
def test_a_transformed_cosine_integrates_to_one(scale, panels):
    mu, weight = panels([0.0, 1.0], 8, 12)
    density = np.asarray(stretched_cosine(mu, scale))
    assert 2.0 * math.pi * weight @ density == pytest.approx(1.0, abs=1e-13)
    assert float(stretched_cosine(-0.5, scale)) == 0.0


def test_derivatives_are_finite_and_those_of_differences():
    polygon = jnp.asarray(flat(TILTED))
    for f, at in (
        (lambda s: lobe_share(polygon, s), 1.3),
        (lambda z: polygon_share(polygon.at[:, 2].add(z)), 0.0),
    ):
        value, step = jax.jit(jax.value_and_grad(f)), 1e-5
        difference = (value(at + step)[0] - value(at - step)[0]) / (2.0 * step)
        assert float(value(at)[1]) == pytest.approx(float(difference), rel=1e-6)
        assert abs(float(difference)) > 0.01


def test_other_shapes_are_refused():
    with pytest.raises(EcfitError, match=r"vertices must have shape \(n, 3\) with n >= 3, got \(2, 3\)"):
        polygon_share([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
