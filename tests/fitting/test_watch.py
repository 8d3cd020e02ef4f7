"""Between the guards: places where a form breaks its limits are found, and become guards."""

import numpy as np
import pytest

from ecfit.fitting.watch import watched, weak_points
from ecfit.forms import Structure, head

DOMAIN = {"mu": (0.0, 1.0), "alpha": (0.0, 1.0)}
# 1 - alpha^2 P / Q with Q = alpha^3 + mu^3 + c alpha mu^2: below 0 along a ray for c < -1.89.
FORM = Structure(
    head("corner"),
    ("alpha", "mu"),
    (np.array([[1.0, 0.0], [0.0, 1.0]]),),
    np.array([[3.0, 0.0], [0.0, 3.0], [1.0, 2.0]]),
)


def test_a_sound_form_has_none():
    assert weak_points(FORM, np.array([0.1, 0.1, 1.0, 0.0]), DOMAIN) is None


def test_a_pole_is_found_where_it_is():
    c = np.array([0.1, 0.1, 1.0, -2.0])
    found = weak_points(FORM, c, DOMAIN)
    assert found is not None
    a, m = found["alpha"], found["mu"]
    assert len(a) == len(m) == 128
    q = (a**3 + m**3 - 2.0 * a * m**2) / (a + m) ** 3
    assert q.max() < 1e-3
    assert ((a >= 0.0) & (a <= 1.0) & (m >= 0.0) & (m <= 1.0)).all()


def test_a_value_above_its_limit_is_found_and_a_margin_counts():
    high = np.array([0.1, -0.05, 1.0, 0.0])  # P < 0 for mu > 2 alpha
    found = weak_points(FORM, high, DOMAIN)
    assert found is not None
    assert (found["mu"] > 2.0 * found["alpha"]).all()
    # P' / Q' is at least 0.1 here, at mu = 0 or alpha = 0: half the margin is held.
    sound = np.array([0.1, 0.1, 1.0, 0.0])
    assert weak_points(FORM, sound, DOMAIN, margin=0.19) is None
    assert weak_points(FORM, sound, DOMAIN, margin=0.3) is not None


@pytest.mark.parametrize("domain", [{"mu": (0.0, 1.0)}, {"mu": (0.0, 1.0), "F0": (0.01, 0.9)}])
def test_any_coordinates(domain):
    names = tuple(domain)
    rows = np.eye(len(names))
    made = Structure(head("ratio"), names, (rows,), np.concatenate([np.zeros((1, len(names))), rows]))
    c = np.r_[np.ones(len(names)), np.full(len(names), -1.5)]
    found = weak_points(made, c, domain)
    assert found is not None
    assert set(found) == set(domain)
    assert (1.0 - 1.5 * sum(found[n] for n in names) < 1e-2).all()


def test_they_become_guards(curve):
    problem = curve(np.exp)
    before = len(problem.descent.guard_columns[0])
    watched(problem.descent, problem.structure, {"mu": np.linspace(0.0, 1.0, 128)})
    guards = problem.descent.guards
    assert len(problem.descent.guard_columns[0]) == before + 128
    assert guards.data.shape[-1] == guards.factors.shape[-1] == before + 128
    np.testing.assert_allclose(problem.descent.guard_columns[-1][before:, 1], np.linspace(0.0, 1.0, 128))
