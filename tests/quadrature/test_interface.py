"""The rule for an interface against integrals in other coordinates, its own finest level, and its limits.

Both lobes are in energy transport here: T counts eta^2 times the radiance BSDF.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from ecfit._jax import jax, jnp
from ecfit.microfacet import G1, NDFS, DielectricFresnel
from ecfit.quadrature import Interface

SIDES = ("entering", "leaving")
each_side = pytest.mark.parametrize("side", SIDES)

# (mu, r, ior, side, masking, R, T) by benchmarks/reference.py: double-exponential rules in polar coordinates
# around wo, good to 1e-12, which share no code with ecfit. Grazing, nearly a mirror, next to the critical
# angle and on it, a faint interface and a strong one.
REFERENCE = (
    (0.001, 0.03, 1.5, "entering", "separable", 0.8650468640581, 0.0181812192138),
    (0.001, 0.5, 1.5, "entering", "height-correlated", 0.2238895621044, 0.7717054263568),
    (0.001, 1.0, 3.0, "entering", "separable", 0.1645250118980, 0.3229568579406),
    (0.001, 0.2, 1.001, "entering", "height-correlated", 0.0568100157527, 0.8609839705578),
    (0.05, 0.03, 3.0, "entering", "height-correlated", 0.7286715686319, 0.2711941572429),
    (0.3, 0.1, 1.5, "entering", "separable", 0.2073054746224, 0.7924506189063),
    (0.3, 0.7, 1.001, "entering", "separable", 0.0000040193087, 0.7028285062940),
    (0.6, 0.4, 1.5, "entering", "height-correlated", 0.0614482334575, 0.9259302693286),
    (0.8, 1.0, 3.0, "entering", "separable", 0.0858945598131, 0.5979389131486),
    (1.0, 0.03, 1.5, "entering", "separable", 0.0399999779691, 0.9599999349791),
    (1.0, 0.5, 1.5, "entering", "height-correlated", 0.0370486631778, 0.9549960082567),
    (1.0, 1.0, 1.001, "entering", "separable", 0.0000000851676, 0.9996682133814),
    (0.98, 0.2, 3.0, "entering", "height-correlated", 0.2496011509587, 0.7499086902505),
    (0.001, 0.03, 1.5, "leaving", "separable", 0.8824928038146, 0.0000004910342),
    (0.001, 0.5, 1.5, "leaving", "height-correlated", 0.8681721193079, 0.0002018591984),
    (0.001, 1.0, 3.0, "leaving", "separable", 0.5810606490931, 0.0000013102204),
    (0.001, 0.2, 1.001, "leaving", "height-correlated", 0.3527561784998, 0.0122893609102),
    (0.05, 0.03, 3.0, "leaving", "height-correlated", 0.9998321397996, 0.0000001767961),
    (0.3, 0.1, 1.5, "leaving", "separable", 0.9991658872820, 0.0001333156156),
    (0.3, 0.7, 1.001, "leaving", "separable", 0.0000042523965, 0.6978270966382),
    (0.6, 0.4, 1.5, "leaving", "height-correlated", 0.8255451225945, 0.0978646094000),
    (0.8, 1.0, 3.0, "leaving", "separable", 0.2680008603540, 0.0682713661500),
    (1.0, 0.03, 1.5, "leaving", "separable", 0.0400003073212, 0.9599988817051),
    (1.0, 0.5, 1.5, "leaving", "height-correlated", 0.0479064618691, 0.8813230732412),
    (1.0, 1.0, 1.001, "leaving", "separable", 0.0000000852205, 0.9976718719656),
    (0.98, 0.2, 3.0, "leaving", "height-correlated", 0.2745693141897, 0.7235103558260),
    (0.04368785064204479, 0.03, 1.001, "leaving", "separable", 0.9331998742364, 0.0656947474780),
    (0.044687850642044794, 0.03, 1.001, "leaving", "separable", 0.7649256927482, 0.2333716561739),
    (0.045687850642044794, 0.03, 1.001, "leaving", "separable", 0.4916595316145, 0.5070311430814),
    (0.04368785064204479, 0.5, 1.001, "leaving", "height-correlated", 0.0056620268885, 0.5518237400270),
    (0.044687850642044794, 0.5, 1.001, "leaving", "height-correlated", 0.0054503734504, 0.5543220276243),
    (0.7443559924999299, 0.03, 1.5, "leaving", "separable", 0.9835478925394, 0.0164464981941),
    (0.7453559924999299, 0.03, 1.5, "leaving", "separable", 0.9058329763685, 0.0941435606186),
    (0.7463559924999299, 0.03, 1.5, "leaving", "separable", 0.7371460315249, 0.2628357974035),
    (0.7453559924999299, 0.3, 1.5, "leaving", "height-correlated", 0.5875888692465, 0.3890472472717),
    (0.7463559924999299, 0.3, 1.5, "leaving", "height-correlated", 0.5806954115133, 0.3960195672440),
    (0.9418090415820634, 0.1, 3.0, "leaving", "separable", 0.8105881723271, 0.1889622247501),
    (0.9428090415820634, 0.1, 3.0, "leaving", "separable", 0.7298236148214, 0.2696784234094),
    (0.9438090415820634, 0.1, 3.0, "leaving", "separable", 0.6389144411559, 0.3605882987551),
    (0.9428090415820634, 1.0, 3.0, "leaving", "height-correlated", 0.2429044996471, 0.0716914620034),
    (0.9438090415820634, 1.0, 3.0, "leaving", "height-correlated", 0.2426902171721, 0.0717032868188),
)  # fmt: skip

# Points that one compiled function takes: all calls are padded to it.
_POINTS = 240
_BATCH = 48


class Lobes(NamedTuple):
    """R and T of many points and their error estimates."""

    R: np.ndarray
    T: np.ndarray
    R_error: np.ndarray
    T_error: np.ndarray


@cache
def compiled(side: str, level: int, maskings: tuple[str, ...]):
    """Both lobes at (mu, r, ior) with each masking: compiling is what these tests spend their time on."""

    def one(point):
        mu, r, ior = point
        eta = ior if side == "entering" else 1.0 / ior
        found = []
        for masking in maskings:
            rule = Interface(NDFS["ggx"], masking, r * r, eta, DielectricFresnel(eta), side == "leaving")
            reflected, passed = (rule.albedo(mu, level, lobe) for lobe in ("reflection", "transmission"))
            e2 = eta * eta
            found.append(Lobes(reflected.value, e2 * passed.value, reflected.error, e2 * passed.error))
        return found

    return jax.jit(lambda points: jax.lax.map(one, points, batch_size=_BATCH))


# Both forms of masking at one level: it changes a factor of the integrand, which all levels share.
BOTH = ("separable", "height-correlated")
MASKINGS = {0: BOTH[:1], 1: BOTH[:1], 2: BOTH, 4: BOTH[:1]}
FINEST = len(Interface.ORDERS) - 1


def lobes(side: str, level: int, mu, r, ior, masking: str = "separable") -> Lobes:
    """Both lobes at points given as arrays that broadcast to one dimension."""
    columns = [np.asarray(c, dtype=float) for c in np.broadcast_arrays(mu, r, ior)]
    count = columns[0].size
    padded = tuple(np.concatenate([c, np.full(_POINTS - count, c[-1])]) for c in columns)
    found = compiled(side, level, MASKINGS[level])(padded)[MASKINGS[level].index(masking)]
    return Lobes(*(np.asarray(v)[:count] for v in found))


def critical_cosine(ior):
    """Below it a smooth surface reflects all light from inside."""
    return np.sqrt((1.0 - 1.0 / ior) * (1.0 + 1.0 / ior))


@cache
def stress(side: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(mu, r, ior): a third spread evenly, a third grazing, and a third near the critical angle."""
    rng = np.random.default_rng(7)
    third = 50
    r = np.where(rng.random(3 * third) < 0.5, rng.random(3 * third), 10.0 ** rng.uniform(-2, 0, 3 * third))
    ior = 1.0 + 10.0 ** rng.uniform(-3, math.log10(2.0), 3 * third)
    grazing = 10.0 ** rng.uniform(-8, 0, third)
    near = 10.0 ** rng.uniform(-8, -1, third) * rng.choice([-1.0, 1.0], third)
    last = critical_cosine(ior[-third:]) + near if side == "leaving" else 1.0 - np.abs(near)
    return np.concatenate([rng.random(third), grazing, np.clip(last, 0.0, 1.0)]), r, ior


def reference(side: str, masking: str) -> np.ndarray:
    """Rows of (mu, r, ior, R, T)."""
    return np.array([(*row[:3], *row[5:]) for row in REFERENCE if row[3:5] == (side, masking)])


@each_side
@pytest.mark.parametrize("masking", BOTH)
def test_integrals_in_other_coordinates_agree(side, masking):
    mu, r, ior, R, T = reference(side, masking).T
    found = lobes(side, 2, mu, r, ior, masking)
    np.testing.assert_allclose(found.R, R, atol=1e-8)
    np.testing.assert_allclose(found.T, T, atol=1e-8)


@each_side
@pytest.mark.parametrize(("level", "masking"), [(1, "separable"), *((2, m) for m in BOTH)])
def test_estimates_cover_the_distance_from_those_integrals(side, masking, level):
    mu, r, ior, R, T = reference(side, masking).T
    found = lobes(side, level, mu, r, ior, masking)
    # wo is kept 1e-9 off the normal, which the estimates do not count; E has slopes of about 1 there.
    shift = np.where(mu == 1.0, 1e-9, 0.0)
    assert np.all(np.abs(found.R - R) <= found.R_error + shift)
    assert np.all(np.abs(found.T - T) <= found.T_error + shift)


@each_side
@pytest.mark.parametrize("level", [pytest.param(0, marks=pytest.mark.slow), 1, 2])
def test_estimates_are_honest(side, level):
    found, truth = (lobes(side, n, *stress(side)) for n in (level, FINEST))
    assert np.all(np.isfinite(found))
    assert np.all(np.abs(found.R - truth.R) <= found.R_error + 1e-12)
    assert np.all(np.abs(found.T - truth.T) <= found.T_error + 1e-12)


@each_side
def test_the_default_level_is_accurate(side):
    mu, r, ior = stress(side)
    found, truth = (lobes(side, n, mu, r, ior) for n in (Interface.default_level, FINEST))
    assert max(np.abs(found.R - truth.R).max(), np.abs(found.T - truth.T).max()) <= 1e-5
    usual = (r >= 0.03) & (mu >= 1e-3)
    assert np.count_nonzero(usual) > 80
    assert np.abs(found.R - truth.R)[usual].max() <= 1e-7
    assert np.abs(found.T - truth.T)[usual].max() <= 1e-7


@each_side
@pytest.mark.parametrize("masking", BOTH)
def test_energy_is_conserved(side, masking):
    """At all ends of the ranges: grazing and normal, mirror and roughest, no interface and the strongest."""
    mu, alpha, ior = (
        v.ravel() for v in np.meshgrid([0.0, 1e-8, 0.3, 1.0], [0.0, 1e-3, 0.5, 1.0], [1.0, 1.5, 100.0])
    )
    found = lobes(side, 2, mu, np.sqrt(alpha), ior, masking)
    assert np.all(np.isfinite(found))
    assert np.all(-found.R_error <= found.R)
    assert np.all(-found.T_error <= found.T)
    total, error = found.R + found.T, found.R_error + found.T_error
    assert np.all(total <= 1.0 + error)


@each_side
@pytest.mark.parametrize("ior", [1.001, 1.5, 3.0])
def test_a_smooth_surface_divides_light_as_fresnel_says(side, ior):
    """F = 1 is part of it: beyond the critical angle nothing passes."""
    mu = np.array([1e-3, 0.02, 0.2, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0])
    found = lobes(side, 1, mu, 0.0, ior)
    eta = jnp.asarray(ior if side == "entering" else 1.0 / ior)
    fresnel = np.asarray(DielectricFresnel(eta)(jnp.asarray(mu)))
    np.testing.assert_allclose(found.R, fresnel, atol=1e-9)
    np.testing.assert_allclose(found.T, 1.0 - fresnel, atol=1e-9)
    if side == "leaving":
        beyond = mu < critical_cosine(ior)
        assert 0 < np.count_nonzero(beyond) < mu.size
        np.testing.assert_array_equal(found.T[beyond], 0.0)


@each_side
def test_a_nearly_smooth_surface_is_near_the_limit(side):
    mu = np.array([0.3, 0.6, 0.9, 1.0])
    smooth, nearly = (lobes(side, 1, mu, r, 1.5) for r in (0.0, 1e-2))
    np.testing.assert_allclose(nearly.R, smooth.R, atol=1e-5)
    np.testing.assert_allclose(nearly.T, smooth.T, atol=1e-5)


@each_side
@pytest.mark.parametrize("masking", BOTH)
def test_equal_indices_reflect_nothing_and_let_pass_what_is_not_masked(side, masking):
    """Light goes straight on and meets the masking of its own direction again: with Lambda of mu,
    T = G2 / G1 = 1 / (1 + Lambda) = G1, and (1 + Lambda) / (1 + 2 Lambda) with height correlation."""
    mu, r = (v.ravel() for v in np.meshgrid([1e-3, 0.1, 0.5, 1.0], [0.05, 0.3, 0.7, 1.0]))
    found = lobes(side, 2, mu, r, 1.0, masking)
    g1 = np.asarray(G1(NDFS["ggx"], jnp.asarray(mu), jnp.asarray(r * r)))
    assert np.all(np.abs(found.R) <= found.R_error)  # a difference, when leaving
    np.testing.assert_allclose(found.R, 0.0, atol=1e-6)
    np.testing.assert_allclose(found.T, g1 if masking == "separable" else 1.0 / (2.0 - g1), atol=1e-8)


def test_both_lobes_together_are_their_sum_in_radiance():
    """The measure is that of the radiance BSDF: T / eta^2."""
    eta = jnp.asarray(1.0 / 1.5)
    rule = Interface(NDFS["ggx"], "separable", jnp.asarray(0.25), eta, DielectricFresnel(eta), True)
    both = jax.jit(lambda mu: rule.albedo(mu, 1, "all"))(0.5)
    apart = lobes("leaving", 1, 0.5, [0.5], 1.5)
    assert float(both.value) == pytest.approx(float(apart.R[0] + 1.5**2 * apart.T[0]), rel=1e-13)
    assert float(both.error) == pytest.approx(float(apart.R_error[0] + 1.5**2 * apart.T_error[0]), rel=1e-6)


@each_side
def test_stated_node_counts_are_those_evaluated(side):
    """They size the blocks in memory."""
    seen: list[int] = []

    class Counting(DielectricFresnel):
        def __call__(self, x):
            seen.append(math.prod(x.shape))
            return super().__call__(x)

    eta = jnp.asarray(1.5 if side == "entering" else 1.0 / 1.5)
    rule = Interface(NDFS["ggx"], "separable", jnp.asarray(0.5), eta, Counting(eta), side == "leaving")
    for level, stated in enumerate(rule.levels):
        seen.clear()
        # Shapes are all that is asked for: nothing is computed.
        jax.eval_shape(lambda mu, level=level: rule.albedo(mu, level, "all"), jnp.asarray(0.5))
        # What is totally reflected, when leaving, needs no Fresnel factor and is counted apart.
        assert sum(seen) <= stated <= 2 * sum(seen)


@cache
def slopes(side: str):
    """R + T / 2 and its gradients in mu, alpha, ior: unlike weights, as the sum would hide what cancels."""

    def value(mu, alpha, ior):
        eta = ior if side == "entering" else 1.0 / ior
        rule = Interface(NDFS["ggx"], "separable", alpha, eta, DielectricFresnel(eta), side == "leaving")
        R, T = (rule.albedo(mu, 1, lobe).value for lobe in ("reflection", "transmission"))
        return R + 0.5 * eta**2 * T

    return jax.jit(jax.vmap(jax.value_and_grad(value, (0, 1, 2))))


# Compiling gradients takes longest of all. What leaves meets the code of what enters, and more.
each_side_slowly = pytest.mark.parametrize(
    "side", [pytest.param("entering", marks=pytest.mark.slow), "leaving"]
)


def slopes_at(side: str, points: list[tuple[float, float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Values (points,) and gradients (3, points) at rows of (mu, alpha, ior); one size, one compilation."""
    padded = points + [points[-1]] * (32 - len(points))
    value, slope = slopes(side)(*np.array(padded).T)
    return np.asarray(value)[: len(points)], np.asarray(slope)[:, : len(points)]


@each_side_slowly
def test_gradients_agree_with_central_differences(side):
    at = [(0.3, 0.4, 1.5), (0.9, 0.4, 1.5), (0.5, 0.8, 2.2), (0.2, 0.15, 1.2), (0.95, 0.1, 1.1)]
    slope = slopes_at(side, at)[1]
    step = 1e-6
    for k, name in enumerate(("mu", "alpha", "ior")):
        shift = step * np.eye(3)[k]
        up, down = (slopes_at(side, [tuple(p + sign * shift) for p in at])[0] for sign in (1.0, -1.0))
        np.testing.assert_allclose(slope[k], (up - down) / (2.0 * step), rtol=1e-6, atol=1e-7, err_msg=name)


@each_side_slowly
def test_gradients_are_finite_at_the_ends_and_at_the_critical_angle(side):
    """A smooth surface's albedo has a root at the critical angle, whose slope is infinite from one side."""
    ends = [(mu, alpha, ior) for mu in (1e-3, 1.0) for alpha in (1e-4, 1.0) for ior in (1.0, 1.5, 100.0)]
    critical = [
        (float(critical_cosine(n)), alpha, n) for n in (1.001, 1.5, 3.0) for alpha in (1e-4, 0.1, 1.0)
    ]
    inside = [(0.1, 0.4, 1.0), (0.8, 0.4, 1.0)]
    assert np.all(np.isfinite(slopes_at(side, ends + critical + inside)[1]))


@each_side_slowly
def test_gradients_are_finite_at_grazing(side):
    slope = slopes_at(side, [(0.0, alpha, ior) for alpha in (0.3, 1.0) for ior in (1.5, 100.0)])[1]
    assert np.all(np.isfinite(slope))
    assert np.abs(slope).max() < 10.0  # of order 1


@each_side_slowly
def test_gradients_are_finite_at_grazing_without_an_interface(side):
    assert np.all(np.isfinite(slopes_at(side, [(0.0, 0.3, 1.0), (0.0, 1.0, 1.0)])[1]))


@each_side_slowly
def test_the_slope_at_the_normal_is_the_one_sided_difference(side):
    """Errors of the value are divided by sin(theta_o) in the slope: two digits are left there."""
    step = 1e-3
    for alpha, ior in ((0.3, 1.5), (1.0, 1.5), (0.3, 3.0)):
        at = [(1.0 - k * step, alpha, ior) for k in range(3)]
        e, slope = slopes_at(side, at)
        difference = (3.0 * e[0] - 4.0 * e[1] + e[2]) / (2.0 * step)  # of second order
        assert slope[0, 0] == pytest.approx(difference, abs=2e-2)
