"""The half-vector rule against integrals over directions of light, and its own finest level.

Dishonest (an estimate below the error) and inaccurate (an error above what the level is good for) fail apart.
"""

import itertools
import math
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.microfacet import MASKINGS, NDFS, UnitFresnel
from ecfit.quadrature import HalfVectorReflection
from ecfit.quadrature.half_vector import azimuths, horizon

LEVELS = tuple(range(len(HalfVectorReflection.ORDERS)))
FINEST = LEVELS[-1]

# Each costs a compilation a level: Beckmann's forms of masking differ only as GGX's do.
COMBINATIONS = (("ggx", "separable"), ("ggx", "height-correlated"), ("beckmann", "separable"))

each_ndf = pytest.mark.parametrize("ndf", NDFS)
each_masking = pytest.mark.parametrize("masking", MASKINGS)
each_combination = pytest.mark.parametrize(("ndf", "masking"), COMBINATIONS)


def sample() -> tuple[np.ndarray, np.ndarray]:
    """(mu, r): a third spread evenly, a third over all magnitudes, and the corners."""
    rng = np.random.default_rng(20)
    mu = np.concatenate(
        [rng.random(120), 10.0 ** rng.uniform(-8, 0, 120), 1 - 10.0 ** rng.uniform(-8, 0, 38)]
    )
    r = np.where(rng.random(mu.size) < 0.5, rng.random(mu.size), 10.0 ** rng.uniform(-3, 0, mu.size))
    ends = np.array([0.0, 1e-8, 1e-5, 1e-3, 0.02, 0.5, 1.0])
    corners = np.meshgrid(ends, np.array([1e-3, 1e-2, 0.035, 0.1, 0.5, 1.0]))
    return np.concatenate([mu, corners[0].ravel()]), np.concatenate([r, corners[1].ravel()])


MU, R = sample()
_BATCH = 64
assert MU.size % _BATCH == 0  # or the rest is compiled for itself


class Computed(NamedTuple):
    values: np.ndarray
    errors: np.ndarray


@cache
def _computed(level: int) -> dict[tuple[str, str], Computed]:
    """All points of the sample by one level, with F = 1: one compilation for all combinations."""

    def one(point):
        mu, r = point
        rules = [HalfVectorReflection(NDFS[n], m, r * r, UnitFresnel()) for n, m in COMBINATIONS]
        return [rule.albedo(mu, level, "all") for rule in rules]

    run = jax.jit(lambda points: jax.lax.map(one, points, batch_size=_BATCH))
    found = run((jnp.asarray(MU), jnp.asarray(R)))
    return {c: Computed(*(np.asarray(v) for v in e)) for c, e in zip(COMBINATIONS, found, strict=True)}


def computed(ndf: str, masking: str, level: int) -> Computed:
    return _computed(level)[ndf, masking]


def albedo(mu: float, alpha: float, ndf: str = "ggx", masking: str = "separable", level: int = 3) -> float:
    model = ecfit.model("conductor", ndf=ndf, masking=masking)
    return float(ecfit.directional_albedo(model, mu=mu, alpha=alpha, level=level))


def test_the_closed_form_at_the_normal_of_the_roughest_surface():
    assert albedo(1.0, 1.0) == pytest.approx(1.0 - math.log(2.0), abs=1e-13)
    assert albedo(1.0, 1.0, level=0) == pytest.approx(1.0 - math.log(2.0), abs=1e-9)


@each_ndf
@each_masking
@pytest.mark.parametrize(("mu", "alpha"), [(1.0, 0.1), (0.7, 0.3), (0.2, 0.5), (0.05, 0.8), (0.3, 1.0)])
def test_integrals_over_directions_agree(ndf, masking, mu, alpha, reference_albedo):
    expected = reference_albedo(ndf, masking, mu, alpha)
    # Beckmann's slopes end at a cut where the GGX rule reaches infinity: 2e-10 at this level.
    tolerance = 1e-12 if ndf == "ggx" else 1e-9
    assert albedo(mu, alpha, ndf, masking) == pytest.approx(expected, abs=tolerance)


def test_fresnel_factors_weigh_the_integrand(reference_albedo):
    model = ecfit.model("conductor", fresnel="schlick", F0=0.1, F90=0.8)
    for mu, alpha in ((0.15, 0.4), (0.9, 0.7)):
        expected = reference_albedo("ggx", "separable", mu, alpha, lambda x: 0.1 + 0.7 * (1.0 - x) ** 5)
        assert float(ecfit.directional_albedo(model, mu=mu, alpha=alpha, level=3)) == pytest.approx(
            expected, abs=1e-11
        )


@each_combination
@pytest.mark.parametrize("level", LEVELS)
def test_estimates_are_honest(ndf, masking, level):
    values, errors = computed(ndf, masking, level)
    truth = computed(ndf, masking, FINEST).values
    assert np.all(np.isfinite(errors))
    assert np.all(np.abs(values - truth) <= errors + 1e-12)


@cache
def near_the_normal(level: int):
    """Estimates near the normal at small r, where the decay of GGX's coefficients promises too much."""
    mu, r = (v.ravel() for v in np.meshgrid(np.linspace(0.99, 1.0, 8), np.linspace(0.02, 0.1, 30)))

    def one(mu, r):
        return HalfVectorReflection(NDFS["ggx"], "separable", r * r, UnitFresnel()).albedo(mu, level, "all")

    return jax.jit(jax.vmap(one))(jnp.asarray(mu), jnp.asarray(r))


@pytest.mark.parametrize("level", LEVELS[:2])
def test_estimates_are_honest_where_coefficients_fall_slowly(level):
    found, truth = near_the_normal(level), near_the_normal(FINEST)
    assert np.all(np.abs(np.asarray(found.value - truth.value)) <= np.asarray(found.error) + 1e-12)


@each_masking
def test_the_default_level_is_accurate(masking):
    errors = np.abs(
        computed("ggx", masking, HalfVectorReflection.default_level).values
        - computed("ggx", masking, FINEST).values
    )
    usual = (R >= 1e-2) & (MU >= 1e-3)
    assert np.count_nonzero(usual) > 100
    assert errors[usual].max() <= 1e-7
    assert errors.max() <= 1e-6


def test_beckmann_takes_more_nodes_but_gets_there():
    truth = computed("beckmann", "separable", FINEST).values
    usual = (R >= 1e-2) & (MU >= 1e-3)
    for level, bound in ((1, 2e-6), (2, 1e-7), (3, 2e-9)):
        assert np.abs(computed("beckmann", "separable", level).values - truth)[usual].max() <= bound


@each_combination
def test_levels_converge(ndf, masking):
    truth = computed(ndf, masking, FINEST).values
    worst = [np.abs(computed(ndf, masking, level).values - truth).max() for level in LEVELS[:-1]]
    assert all(later < 0.2 * earlier for earlier, later in itertools.pairwise(worst))


@each_combination
@pytest.mark.parametrize("level", [0, FINEST])
def test_white_energy_is_conserved(ndf, masking, level):
    values, errors = computed(ndf, masking, level)
    assert values.min() > 0.0
    assert np.all(values <= 1.0 + 1e-12 + errors)
    assert computed(ndf, masking, FINEST).values.max() <= 1.0 + 1e-12


@each_combination
def test_a_mirror_reflects_everything(ndf, masking):
    mu = jnp.asarray([0.0, 1e-8, 1e-3, 0.5, 0.9, 1.0])
    model = ecfit.model("conductor", ndf=ndf, masking=masking)
    np.testing.assert_allclose(ecfit.directional_albedo(model, mu=mu, alpha=0.0), 1.0, atol=1e-12)


def test_a_mirror_reflects_what_its_fresnel_factor_says():
    mu = jnp.asarray([0.0, 1e-8, 1e-3, 0.5, 0.9, 1.0])
    schlick = ecfit.model("conductor", fresnel="schlick", F0=0.3)
    expected = 0.3 + 0.7 * (1.0 - np.asarray(mu)) ** 5
    np.testing.assert_allclose(ecfit.directional_albedo(schlick, mu=mu, alpha=0.0), expected, atol=1e-12)


@each_combination
def test_grazing_is_the_limit_of_small_mu(ndf, masking):
    model = ecfit.model("conductor", ndf=ndf, masking=masking)
    mu, alpha = jnp.asarray([[0.0], [1e-7]]), jnp.asarray([0.05, 0.3, 1.0])
    at_zero, nearby = np.asarray(ecfit.directional_albedo(model, mu=mu, alpha=alpha))
    np.testing.assert_allclose(at_zero, nearby, atol=1e-4)


def test_nothing_is_transmitted():
    found = {
        lobe: float(ecfit.directional_albedo("conductor", mu=0.5, alpha=0.5, lobe=lobe, level=0))
        for lobe in ("all", "reflection", "transmission")
    }
    assert found["transmission"] == 0.0
    assert found["all"] == found["reflection"] > 0.0


def test_stated_node_counts_are_those_evaluated():
    """They size the blocks in memory."""
    seen: list[tuple[int, ...]] = []

    class Counting(UnitFresnel):
        def __call__(self, x):
            seen.append(x.shape)
            return jnp.ones_like(x)

    rule = HalfVectorReflection(NDFS["ggx"], "separable", jnp.asarray(0.5), Counting())
    for level in LEVELS:
        # Shapes are all that is asked for: nothing is computed.
        jax.eval_shape(lambda mu, level=level: rule.albedo(mu, level, "all"), jnp.asarray(0.5))
    assert tuple(math.prod(shape) for shape in seen) == rule.levels


@pytest.mark.parametrize("mu", [0.0, 1e-9, 1e-3, 0.3, 1.0])
def test_azimuths_cover_the_circle(mu, panels):
    """The map's Jacobian integrates 1 to 2 pi and cos^2 to pi, however narrow its scale."""
    t, w = panels([0.0, 0.5, 1.0], 0, 40)
    c, jacobian = azimuths(jnp.asarray(mu), t)
    assert float(jnp.asarray(w) @ jacobian) == pytest.approx(2.0 * math.pi, rel=1e-12)
    assert float(jnp.asarray(w) @ (jacobian * c * c)) == pytest.approx(math.pi, rel=1e-9)


@pytest.mark.parametrize("mu", [1e-12, 1e-3, 0.4, 0.999])
def test_light_meets_the_horizon_at_the_stated_slope(mu):
    s = math.sqrt(1.0 - mu * mu)
    phi = np.linspace(0.05, math.pi - 0.05, 20)
    num, den = (np.asarray(v) for v in horizon(jnp.asarray(mu), jnp.asarray(s), jnp.cos(jnp.asarray(phi))))
    theta = np.arctan2(num, den)
    cos_i = s * np.cos(phi) * np.sin(2.0 * theta) + mu * np.cos(2.0 * theta)
    np.testing.assert_allclose(cos_i, 0.0, atol=1e-14)
    assert np.all((theta > 0.0) & (theta < 0.5 * math.pi))


@cache
def slopes(ndf: str, masking: str, fresnel: str):
    """Values and gradients at points of all the parameters that matter, by one compilation."""
    model = ecfit.model("conductor", ndf=ndf, masking=masking, fresnel=fresnel)

    def one(point):
        return ecfit.directional_albedo(model, **point)

    return jax.jit(jax.vmap(jax.value_and_grad(one)))


def points(rows: list[dict[str, float]]) -> dict[str, np.ndarray]:
    """The rows as columns, padded with the last row to one length: one compilation."""
    rows = rows + [rows[-1]] * (16 - len(rows))
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


GENERIC = {
    ("beckmann", "separable", "unit"): [{"mu": 0.4, "alpha": 0.3}, {"mu": 0.9, "alpha": 0.8}],
    ("ggx", "separable", "schlick"): [
        {"mu": 0.3, "alpha": 0.5, "F0": 0.2, "F90": 0.9},
        {"mu": 0.8, "alpha": 0.2, "F0": 0.9, "F90": 1.0},
        {"mu": 0.1, "alpha": 0.1, "F0": 1.0, "F90": 1.0},
    ],
    ("ggx", "height-correlated", "exact"): [
        {"mu": 0.6, "alpha": 0.4, "eta": 0.2, "k": 3.9},
        {"mu": 0.2, "alpha": 0.6, "eta": 1.5, "k": 0.3},
    ],
}


# Each costs seconds of compilation: the fast tests are those of one model.
FAST = ("ggx", "separable", "schlick")
each_ndf_slowly = pytest.mark.parametrize("ndf", ["ggx", pytest.param("beckmann", marks=pytest.mark.slow)])


@pytest.mark.parametrize(
    "options", [o if o == FAST else pytest.param(o, marks=pytest.mark.slow) for o in GENERIC], ids="-".join
)
def test_gradients_agree_with_central_differences(options):
    evaluate = slopes(*options)
    at = points(GENERIC[options])
    slope = evaluate(at)[1]
    for name in at:
        step = 1e-5
        up, down = (np.asarray(evaluate({**at, name: at[name] + sign * step})[0]) for sign in (1, -1))
        np.testing.assert_allclose(slope[name], (up - down) / (2.0 * step), atol=1e-7, err_msg=name)


# F = 1 in two ways, so that no other compilation is needed than those above.
WHITE = {"ggx": ("schlick", {"F0": 1.0, "F90": 1.0}), "beckmann": ("unit", {})}


@each_ndf_slowly
def test_gradients_are_finite_up_to_the_normal_and_down_to_a_mirror(ndf):
    fresnel, white = WHITE[ndf]
    ends = [{"mu": mu, "alpha": a, **white} for mu in (1e-3, 0.5, 1.0) for a in (0.0, 1e-8, 1e-4, 0.3, 1.0)]
    slope = slopes(ndf, "separable", fresnel)(points(ends))[1]
    assert np.all(np.isfinite(slope["mu"]))
    assert np.all(np.isfinite(slope["alpha"]))


@each_ndf_slowly
def test_the_slope_at_the_normal_is_the_one_sided_difference(ndf):
    fresnel, white = WHITE[ndf]
    evaluate = slopes(ndf, "separable", fresnel)
    step = 1e-3
    at = points([{"mu": 1.0 - k * step, "alpha": 0.7, **white} for k in range(3)])
    e, gradient = evaluate(at)
    difference = float(3.0 * e[0] - 4.0 * e[1] + e[2]) / (2.0 * step)  # of second order
    assert float(gradient["mu"][0]) == pytest.approx(difference, abs=1e-5)


def test_schlick_albedo_is_linear_in_F0_and_F90():
    model = ecfit.model("conductor", fresnel="schlick")
    a, b, mixed = ecfit.directional_albedo(
        model, mu=0.4, alpha=0.3, F0=jnp.asarray([1.0, 0.0, 0.3]), F90=jnp.asarray([0.0, 1.0, 0.7])
    )
    assert float(mixed) == pytest.approx(0.3 * float(a) + 0.7 * float(b), rel=1e-13)


def test_points_may_be_mapped_jitted_and_broadcast():
    model = ecfit.model("conductor")
    mu, alpha = jnp.asarray([0.1, 0.5, 0.9]), jnp.asarray([0.2, 0.8])
    table = np.asarray(ecfit.directional_albedo(model, mu=mu[:, None], alpha=alpha))
    assert table.shape == (3, 2)
    mapped = jax.vmap(lambda m: ecfit.directional_albedo(model, mu=m, alpha=alpha))(mu)
    compiled = jax.jit(lambda m: ecfit.directional_albedo(model, mu=m[:, None], alpha=alpha))(mu)
    one = float(ecfit.directional_albedo(model, mu=0.5, r=math.sqrt(0.8)))
    np.testing.assert_allclose(mapped, table, rtol=1e-14)
    np.testing.assert_allclose(compiled, table, rtol=1e-14)
    assert one == pytest.approx(table[1, 1], rel=1e-13)
