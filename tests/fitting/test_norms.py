"""Norms: each is best at its own solution, and names mean what they say."""

from typing import get_args

import numpy as np
import pytest

from ecfit.config.study import NormName
from ecfit.errors import EcfitError
from ecfit.fitting import NORMS
from ecfit.fitting.norms import solve_in_norm
from ecfit.forms.structured import head_from

pytest.importorskip("scipy")

START = np.array([1.0, 0.0, 0.5])
SETTINGS = {"rtol": 1e-9, "max_steps": 200}
# What each name says, in plain words; f is the fit, e the truth.
SIZES = {
    "least-squares": lambda f, e: np.sqrt(np.mean((f - e) ** 2)),
    "l1": lambda f, e: np.mean(np.abs(f - e)),
    "l3": lambda f, e: np.mean(np.abs(f - e) ** 3) ** (1 / 3),
    "l4": lambda f, e: np.mean((f - e) ** 4) ** 0.25,
    "l8": lambda f, e: np.mean((f - e) ** 8) ** 0.125,
    "minimax": lambda f, e: np.max(np.abs(f - e)),
    "furnace-mean": lambda f, e: np.mean(np.abs(e / f - 1.0)),
    "furnace-rms": lambda f, e: np.sqrt(np.mean((e / f - 1.0) ** 2)),
    "furnace-l4": lambda f, e: np.mean((e / f - 1.0) ** 4) ** 0.25,
    "furnace-p99": lambda f, e: np.sort(np.abs(e / f - 1.0))[int(0.99 * e.size) - 1],
    "furnace-max": lambda f, e: np.max(np.abs(e / f - 1.0)),
}
# How far from its own optimum a solution may be: programs and convex norms to rounding and the settling of
# weights; high powers stop early, and a percentile is not convex.
SLACK = {"l3": 1.01, "l4": 1.01, "furnace-l4": 1.01, "l8": 1.03, "furnace-p99": 1.1}


def curved(mu):
    return 0.4 + 0.5 * np.exp(-2.0 * mu) + 0.05 * np.sin(9.0 * mu)


@pytest.fixture(scope="module")
def values(curve):
    """The fit of each norm on the nodes, and the truth."""
    problem = curve(curved)
    out = {}
    for name, norm in NORMS.items():
        found = solve_in_norm(problem.descent, problem.support, 0, START, norm, **SETTINGS)
        assert found.converged
        out[name] = problem.descent.value(problem.support, 0, found.coefficients)[0]
    return out, problem.table.values


def test_the_configs_names_are_those_of_the_norms():
    assert set(get_args(NormName)) == set(NORMS) == set(SIZES)
    assert all(name == norm.name and norm.meaning for name, norm in NORMS.items())


@pytest.mark.parametrize("name", NORMS)
def test_no_other_norms_solution_is_smaller_in_a_norm(values, name: str):
    found, truth = values
    sizes = {other: SIZES[name](f, truth) for other, f in found.items()}
    assert sizes[name] <= min(sizes.values()) * SLACK.get(name, 1.001), sizes


def test_the_norms_differ(values):
    found, truth = values
    for name in ("l1", "minimax", "furnace-max"):
        assert SIZES[name](found[name], truth) < 0.98 * SIZES[name](found["least-squares"], truth)


def test_higher_powers_lower_the_maximum(values):
    found, truth = values
    largest = [SIZES["minimax"](found[n], truth) for n in ("l1", "least-squares", "l4", "l8", "minimax")]
    assert np.all(np.diff(largest) < 0.0)


def test_l1_does_not_mind_an_outlier(curve):
    spike = np.where(np.arange(120) == 37, 0.5, 0.0)
    problem = curve(lambda mu: (0.9 - 0.3 * mu) / (1.0 + 0.8 * mu) + spike)

    def solve(name: str, **more) -> np.ndarray:
        norm = NORMS[name]
        found = solve_in_norm(problem.descent, problem.support, 0, START, norm, **more, **SETTINGS)
        return found.coefficients

    off = {n: np.abs(solve(n) - [0.9, -0.3, 0.8]).max() for n in ("l1", "least-squares")}
    assert off["l1"] < 0.05 * off["least-squares"]
    # A weight of 0 hides it from any norm.
    for name in ("least-squares", "minimax", "furnace-rms"):
        hidden = solve(name, weights=np.where(spike > 0.0, 0.0, 1.0))
        np.testing.assert_allclose(hidden, [0.9, -0.3, 0.8], atol=1e-4)


def test_weights_are_repeated_rows(curve):
    """The weight 3 on half of the rows pulls the fit as three copies would: the weighted error is least."""
    problem = curve(curved)
    weights = np.where(np.arange(120) < 60, 3.0, 1.0)

    def solve(w) -> np.ndarray:
        norm = NORMS["least-squares"]
        found = solve_in_norm(problem.descent, problem.support, 0, START, norm, w, **SETTINGS)
        return problem.descent.value(problem.support, 0, found.coefficients)[0]

    def size(f: np.ndarray) -> float:
        return np.mean(weights * (f - problem.table.values) ** 2)

    assert size(solve(weights)) < size(solve(None)) * 0.999
    np.testing.assert_allclose(solve(5.0 * np.ones(120)), solve(None), atol=1e-7)


def test_a_maximum_needs_a_quotient(curve):
    square = curve(curved, name=head_from({"name": "s", "factors": [{}], "text": "X*X"}))
    with pytest.raises(EcfitError, match="norm 'minimax' needs a head of one ratio: use 'l8' for 's'"):
        solve_in_norm(square.descent, square.support, 0, START, NORMS["minimax"])
