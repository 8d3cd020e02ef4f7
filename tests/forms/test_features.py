"""Features: each is its own scaled self times a power of rho, and means what it says."""

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.expressions import value
from ecfit.expressions.node import inputs
from ecfit.forms.features import (
    COORDINATES,
    FEATURES,
    check_powers,
    coordinates_of,
    monomial,
    order,
    plain,
    scaled,
)


def random_points(count: int = 400) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    return {
        "mu": rng.uniform(1e-3, 1.0, count),
        "alpha": rng.uniform(1e-3, 1.0, count),
        "F0": rng.uniform(0.0, 1.0, count),
        "ior": rng.uniform(1.0, 3.0, count),
    }


def in_chart(points: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    rho = points["alpha"] + points["mu"]
    return {**points, "rho": rho, "t": points["alpha"] / rho}


@pytest.mark.parametrize("name", FEATURES)
def test_scaled_times_rho_to_the_order_is_the_feature(name: str):
    points = random_points()
    chart = in_chart(points)
    expected = np.broadcast_to(value(plain(name), points), points["mu"].shape)
    got = value(scaled(name), chart) * chart["rho"] ** FEATURES[name].order
    np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("name", FEATURES)
def test_the_scaled_feature_is_finite_and_non_negative_up_to_the_corner(name: str):
    t = np.linspace(0.0, 1.0, 11)[:, None]
    rho = np.array([0.0, 1e-300, 1e-9, 1e-3])
    for f0 in (0.0, 0.04, 1.0):
        got = value(scaled(name), {"t": t, "rho": rho, "F0": np.array(f0), "ior": np.array(1.5)})
        assert np.all(np.isfinite(got))
        assert np.all(got >= 0.0)


@pytest.mark.parametrize("name", FEATURES)
def test_the_order_is_the_power_of_rho_along_a_ray(name: str):
    """Against the plain formula alone: f(rho / 2) / f(rho) at the corner, F0 = 0 apart."""
    near = []
    for e in (1e-15, 5e-16):
        at = {"alpha": 0.3 * e, "mu": 0.7 * e, "F0": 0.3, "ior": 1.7}
        near.append(value(plain(name), {n: np.array(v) for n, v in at.items()}))
    assert near[1] / near[0] == pytest.approx(0.5 ** FEATURES[name].order, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("r", 0.5),
        ("g", np.sqrt(0.36 + 0.0625 * 0.64)),
        ("G1", 2.0 / (1.0 + np.sqrt(1.0 + 0.0625 * (1.0 / 0.36 - 1.0)))),  # Heitz 2014, eq. 72
        ("u", 0.4),
        ("s", 0.2),  # (1.5 - 1) / (1.5 + 1)
        ("x", 0.5),
        ("mu_c", np.sqrt(1.0 - 1.0 / 2.25)),
        ("mu_t", np.sqrt(1.0 - 0.64 / 2.25)),  # Snell
    ],
)
def test_features_at_a_point_worked_by_hand(name: str, expected: float):
    at = {"mu": 0.6, "alpha": 0.25, "F0": 0.04, "ior": 1.5}
    got = value(plain(name), {k: np.array(v) for k, v in at.items()})
    assert got == pytest.approx(expected, rel=1e-14)


def test_t_is_what_masking_leaves():
    points = random_points()
    chart = in_chart(points)
    np.testing.assert_allclose(
        value(plain("T"), points) * chart["t"] ** 2, 1.0 - value(plain("G1"), points), atol=1e-13
    )


def test_coordinates_come_in_one_order():
    assert coordinates_of(["F0", "alpha", "mu"]) == ("mu", "alpha", "F0")
    assert coordinates_of(["w"]) == ("mu", "alpha", "F0")
    assert coordinates_of([]) == ()
    for name in FEATURES:
        assert inputs(plain(name)) <= set(COORDINATES)


def test_products_of_powers():
    powers = {"alpha": 1.5, "mu": 0.0, "r": 1.0}
    nodes = {name: plain(name) for name in powers}
    assert value(monomial(powers, nodes), {"alpha": np.array(0.25)}) == pytest.approx(0.25**2)
    assert order(powers) == 2.0
    assert monomial({}, {}).value == 1.0


@pytest.mark.parametrize(
    ("powers", "words"),
    [
        ({"alhpa": 1}, "unknown feature 'alhpa'.*did you mean 'alpha'"),
        ({"alpha": -1}, "here: the exponent of alpha must be in 0..64, got -1"),
        ({"alpha": 65}, "0..64"),
        ({"alpha": float("nan")}, "0..64"),
        ({"alpha": True}, "got True"),
        ({"alpha": "2"}, "got '2'"),
    ],
)
def test_wrong_powers_are_refused(powers, words: str):
    with pytest.raises(EcfitError, match=words):
        check_powers(powers, "here")
