"""Gotanda 2014's formulas against the integral and exact Fresnel; other readings of eq. 8 are worse."""

from functools import cache

import numpy as np
import pytest

import ecfit
from ecfit.approximation import Approximation
from ecfit.coordinates import Axis
from ecfit.metrics import measure
from ecfit.tables.scattered import integrate

DIFFUSE = "gotanda-2014-diffuse"


@cache
def sample() -> tuple[dict[str, np.ndarray], np.ndarray]:
    rng = np.random.default_rng(4)
    mu, mu_i = rng.uniform(0.01, 1.0, (2, 256))
    points = {"alpha": rng.random(256), "mu": mu, "mu_i": mu_i, "cos_phi": np.cos(np.pi * rng.random(256))}
    found = integrate(ecfit.published(DIFFUSE).contract, points, 1e-4)
    assert np.all(found.status == 0)
    return points, found.values


def mean_error(approximation: Approximation) -> float:
    points, wanted = sample()
    return float(np.abs(np.asarray(approximation(**points)) - wanted).mean())


def otherwise(old: str, new: str) -> Approximation:
    """Eq. 8 with a part of its text replaced."""
    data = ecfit.published(DIFFUSE).to_dict()
    lets = [[name, text.replace(old, new)] for name, text in data["let"]]
    assert lets != data["let"]
    return Approximation.from_dict({**data, "let": lets})


def test_the_printed_fit_follows_the_integral():
    assert mean_error(ecfit.published(DIFFUSE)) == pytest.approx(9.05e-3, rel=1e-2)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("(1 - exp((1 - 0.3726732*mu*mu)/(0.188566 + 0.38841*mu)*log(max(1 - mu_i, 1e-12))))", "1"),
        ("0.3726732*mu*mu", "0.3726732*mu"),
        ("exp((5 - 4*a2)*u)/q", "exp((5 - 4*a2)*u)"),
        ("(1 - 0.5*alpha + 0.5*alpha*mu_i)", "(1 - 0.5*alpha*(mu_i - 1))"),
    ],
)
def test_other_readings_are_worse(old, new):
    assert mean_error(otherwise(old, new)) > 1.01 * mean_error(ecfit.published(DIFFUSE))


def test_the_factor_of_V_d_stands_once_and_sigma_is_alpha():
    kept = mean_error(ecfit.published(DIFFUSE))
    data = ecfit.published(DIFFUSE).to_dict()
    once = dict(data["let"])["vd"].split(" * ", 1)[1]
    lets = [[n, f"{t} * {once}" if n == "vd" else t] for n, t in data["let"]]
    assert mean_error(Approximation.from_dict({**data, "let": lets})) > 1.2 * kept
    points, wanted = sample()
    for power in (0.5, 2.0):
        found = np.asarray(ecfit.published(DIFFUSE)(**{**points, "alpha": points["alpha"] ** power}))
        assert np.abs(found - wanted).mean() > 1.4 * kept


def fresnel(low: float, high: float) -> ecfit.Table:
    axes = {"F0": Axis.spaced("F0", 9, low, high), "mu": Axis.spaced("mu", 65)}
    return ecfit.tabulate("dielectric", axes, quantity="fresnel")


def test_the_fresnel_of_a_reflectance_is_exact():
    found = measure(ecfit.published("gotanda-2014-fresnel-reflectance"), fresnel(0.02, 0.96))
    assert found.max_error < 1e-14


def test_a_formula_of_F0_is_judged_where_ior_is_fixed():
    """The table has no axis for it: its contract says ior = 1.5."""
    table = ecfit.tabulate(ecfit.model("dielectric", ior=1.5), {"mu": 401}, quantity="fresnel")
    printed = measure(ecfit.published("gotanda-2014-fresnel"), table)
    assert (printed.mae, printed.max_error) == pytest.approx((2.39e-3, 7.20e-3), rel=1e-2)
    schlick = measure(ecfit.published("schlick-fresnel"), table)
    assert (schlick.mae, schlick.max_error) == pytest.approx((1.29e-2, 3.57e-2), rel=1e-2)
    assert list(schlick.place) == ["mu"]


def test_beyond_the_index_that_it_was_made_for_it_is_no_better_than_schlick():
    table = fresnel(0.3, 0.6)
    printed, schlick = (
        measure(ecfit.published(n), table) for n in ("gotanda-2014-fresnel", "schlick-fresnel")
    )
    assert printed.max_error > 0.9 * schlick.max_error
