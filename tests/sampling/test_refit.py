"""Fits of lobes: each point's best is no worse than its start, and numbers of the form are found again."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.sampling import integrated, lobe_form, technique
from ecfit.sampling.refit import _vector, best_lobes, nearest_form, refit_lobe

PRINTED = lobe_form("portsmouth-2024")
MU, R = (v.ravel() for v in jnp.meshgrid(jnp.linspace(0.0, 1.0, 7), jnp.array([0.2, 0.6, 1.0])))


def test_the_forms_own_lobes_give_it_back():
    lobes = jax.vmap(lambda m, r: _vector(PRINTED, m, r))(MU, R)
    shifted = jax.tree.map(lambda v: v * 1.02, PRINTED)
    found = nearest_form(lobes, shifted, MU, R)
    again = jax.vmap(lambda m, r: _vector(found, m, r))(MU, R)
    np.testing.assert_allclose(again, lobes, atol=1e-5)


@pytest.mark.slow
def test_a_points_best_lobe_has_less_variance():
    lobes, ratio = best_lobes(ecfit.model("eon"), PRINTED, jnp.array([0.3]), jnp.array([1.0]))
    assert lobes.shape == (1, 5)
    assert 0.6 < float(ratio[0]) < 0.9


def test_our_numbers_have_no_more_variance_than_the_printed_ones_and_less_on_average():
    mu, r = np.array([0.0, 0.2, 0.45, 0.7, 1.0]), np.array([[0.05], [0.4], [1.0]])
    eon = ecfit.model("eon")
    ours, printed = (integrated(eon, technique("cltc+uniform", n), mu, r) for n in ("eon", "portsmouth-2024"))
    ratio = np.asarray(ours.variance / printed.variance)
    assert ratio.max() < 1.0
    assert ratio.mean() < 0.75
    np.testing.assert_allclose(ours.mean, 1.0, atol=1e-9)


@pytest.mark.slow
def test_a_refit_lowers_the_variance_at_its_points():
    eon, mu, r = ecfit.model("eon"), np.array([0.1, 0.8]), np.array([[0.3], [1.0]])
    made = refit_lobe(eon, PRINTED, mu, r, max_steps=3, source="a test")
    before, after = (integrated(eon, technique("cltc+uniform", f), mu, r).variance for f in (PRINTED, made))
    assert made.source == "a test"
    assert float(np.max(after / before)) < 1.0
