"""The conductor's f: its formula, reciprocity and behaviour at and below the horizon."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.microfacet import MASKINGS, NDFS


def directions(count: int, seed: int) -> np.ndarray:
    """Unit vectors on the upper hemisphere, shape (count, 3)."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(0.01, 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    s = np.sqrt(1.0 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=-1)


WO, WI = directions(200, 1), directions(200, 2)

each_ndf = pytest.mark.parametrize("ndf", NDFS)
each_masking = pytest.mark.parametrize("masking", MASKINGS)


def values(model, wo, wi):
    return np.asarray(jax.jit(jax.vmap(model.f))(jnp.asarray(wo), jnp.asarray(wi)))


@each_ndf
@each_masking
def test_f_has_the_microfacet_formula(ndf, masking, reference_lambda):
    """F D G2 / (4 mu_o mu_i) (Walter et al. 2007, eq. 20), in textbook functions of NumPy."""
    alpha = 0.4
    h = WO + WI
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    tan2 = 1.0 / h[:, 2] ** 2 - 1.0
    if ndf == "ggx":
        d = alpha**2 / (np.pi * h[:, 2] ** 4 * (alpha**2 + tan2) ** 2)
    else:
        d = np.exp(-tan2 / alpha**2) / (np.pi * alpha**2 * h[:, 2] ** 4)
    l_o, l_i = (reference_lambda(ndf, w[:, 2], alpha) for w in (WO, WI))
    g = 1.0 / ((1.0 + l_o) * (1.0 + l_i)) if masking == "separable" else 1.0 / (1.0 + l_o + l_i)
    fresnel = 0.1 + 0.8 * (1.0 - np.sum(WO * h, axis=-1)) ** 5
    model = ecfit.model(
        "conductor", ndf=ndf, masking=masking, fresnel="schlick", F0=0.1, F90=0.9, alpha=alpha
    )
    np.testing.assert_allclose(
        values(model, WO, WI), fresnel * d * g / (4.0 * WO[:, 2] * WI[:, 2]), rtol=1e-11, atol=1e-300
    )


@each_ndf
@each_masking
def test_f_is_reciprocal_and_positive(ndf, masking):
    model = ecfit.model("conductor", ndf=ndf, masking=masking, fresnel="exact", alpha=0.6)
    there, back = values(model, WO, WI), values(model, WI, WO)
    np.testing.assert_allclose(there, back, rtol=1e-12)
    assert there.min() >= 0.0
    assert there.max() > 0.0


def test_nothing_leaves_below_the_horizon():
    model = ecfit.model("conductor", alpha=0.6)
    below = WI * np.array([1.0, 1.0, -1.0])
    assert np.all(values(model, WO, below) == 0.0)
    assert np.all(values(model, WO, np.array([[1.0, 0.0, 0.0]] * 200)) == 0.0)


def test_gradients_are_finite_above_at_and_below_the_horizon():
    model = ecfit.model("conductor", fresnel="exact", alpha=0.6)

    def value(alpha, wi):
        return model.with_parameters({"alpha": alpha}).f(jnp.array([0.6, 0.0, 0.8]), wi)

    wi = jnp.asarray(
        [[0.6, 0.0, 0.8], [-0.6, 0.0, 0.8], [1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [-0.6, 0.0, -0.8]]
    )
    gradient = jax.jit(jax.vmap(jax.grad(value, (0, 1)), (None, 0)))(0.6, wi)
    assert all(np.all(np.isfinite(g)) for g in gradient)


@pytest.mark.parametrize(
    ("fresnel", "active"),
    [("unit", ("alpha",)), ("schlick", ("alpha", "F0", "F90")), ("exact", ("alpha", "eta", "k"))],
)
def test_only_parameters_with_an_effect_are_active(fresnel, active):
    assert ecfit.model("conductor", fresnel=fresnel).active_parameters() == active
