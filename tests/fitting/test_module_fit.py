"""Fits of a user's module, learned coordinate maps, weights and monotone fits."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import ecfit
from ecfit.errors import EcfitError
from ecfit.fitting.learned import LearnedRational
from ecfit.forms import ModuleForm

GRID = [np.linspace(0.0, 1.0, 81)] * 2


def scalar(value: float):
    return eqx.field(default=value, converter=jnp.asarray)


class Decay(eqx.Module):
    a: jax.Array = scalar(1.0)
    b: jax.Array = scalar(1.0)

    def __call__(self, mu, alpha):
        return 1.0 - self.a * alpha * jnp.exp(-self.b * mu)


class Root(eqx.Module):
    """Its derivative by the exponent is 0 log 0 at mu = 0."""

    p: jax.Array = scalar(0.5)

    def __call__(self, mu, **rest):
        return jnp.exp(self.p * jnp.log(mu))


class Flat(eqx.Module):
    a: jax.Array = scalar(0.5)

    def __call__(self, **coordinates):
        return self.a


@pytest.fixture
def axes(unit_axis) -> tuple[ecfit.Axis, ...]:
    return unit_axis("r", 9), unit_axis("mu", 8)


def test_a_module_is_recovered_in_another_view(make_table, axes):
    table = make_table(lambda r, mu: 1.0 - 0.3 * r * r * np.exp(-2.5 * mu), *axes)
    fit = ecfit.fit(table, Decay())
    assert fit.coefficients == pytest.approx([0.3, 2.5], rel=1e-9)
    assert (fit.status, fit.approximation.variables) == ("converged", ("mu", "alpha"))
    assert fit.approximation.name == "Decay 2"
    assert float(fit(mu=0.0, r=0.5)) == pytest.approx(1.0 - 0.3 * 0.25, rel=1e-9)
    assert float(jax.jit(lambda m: fit(mu=m, alpha=1.0))(0.0)) == pytest.approx(0.7, rel=1e-9)


def test_the_optimum_is_that_of_the_weighted_sum_of_squares(make_table, unit_axis):
    """For a constant it is the weighted mean, of 1/3 and 1/2; Gauss weights of the axis count."""
    axis = ecfit.Axis.spaced("mu", 6, spacing="gauss")
    table = make_table(lambda mu: mu**2, axis)
    assert ecfit.fit(table, Flat2(), weights={"mu": 1}).coefficients == pytest.approx([0.5], rel=1e-9)
    one = np.eye(6)[2]
    assert ecfit.fit(table, Flat2(), weights=one).coefficients == pytest.approx([axis.nodes[2] ** 2])
    assert ecfit.fit(table, Flat2(), digits=3).coefficients.tolist() == [0.333]


class Flat2(eqx.Module):
    a: jax.Array = scalar(0.5)

    def __call__(self, mu):
        return self.a * jnp.ones_like(mu)


@pytest.mark.parametrize(
    ("module", "settings", "message"),
    [
        (Root(), {}, "derivative by the coefficients of the module is not finite at r = 0, mu = 0"),
        (Flat(), {}, r"returned the shape \(\).*must broadcast"),
        (eqx.nn.Identity(), {}, "by keyword|function of"),
        (Flat2(), {}, "is a function of mu: the table has r, mu"),
        (Decay(), {"norm": "l1"}, "norm is for forms with terms"),
        (Decay(), {"weights": {"F0": 1}}, "no coordinate 'F0'"),
        (Decay(), {"weights": {"mu": "1"}}, "needs a power"),
        (Decay(), {"weights": {"mu": -1}}, "weights must be finite"),
        (Decay(), {"weights": np.ones(3)}, r"shape \(3,\), the table \(9, 8\)"),
        (Decay(), {"wieghts": 1}, "did you mean 'weights'"),
    ],
)
def test_what_cannot_be_fitted_is_told(make_table, axes, module, settings, message):
    table = make_table(lambda r, mu: 0.5 + 0.0 * mu, *axes)
    with pytest.raises(EcfitError, match=message):
        ecfit.fit(table, module, **settings)


def test_a_module_may_have_a_start_for_a_table(make_table, unit_axis):
    class Started(Flat2):
        def started(self, table):
            return eqx.tree_at(lambda m: m.a, self, jnp.asarray(table.values.mean()))

    fit = ecfit.fit(make_table(lambda mu: mu, unit_axis("mu", 5)), Started())
    assert fit.coefficients == pytest.approx([0.5], abs=1e-12)


def test_learned_exponents_are_recovered_and_never_worse(make_table, unit_axis, tmp_path):
    table = make_table(lambda mu: (1.0 + mu**1.5) / (1.0 + 0.5 * mu**1.5), unit_axis("mu", 40))
    plain = ecfit.fit(table, ecfit.Rational(1))
    fit = ecfit.fit(table, ModuleForm("learned-rational", {"degree": 1}))
    assert (fit.status, fit.approximation.degree) == ("converged", "1")
    assert plain.rmse > 1e-3
    assert fit.rmse < 1e-10
    assert fit.coefficients == pytest.approx([1.5, 1.0, 1.0, 0.5], rel=1e-6)
    assert fit.smallest.value == pytest.approx(1.0)
    fit.save(tmp_path / "fit.json")
    again = ecfit.Fit.load(tmp_path / "fit.json")
    assert float(again(mu=0.3)) == float(fit(mu=0.3))
    assert np.isfinite(jax.grad(lambda mu: again(mu=mu))(0.0))


def test_a_learned_rational_knows_its_poles():
    module = eqx.tree_at(
        lambda m: (m.exponents, m.coefficients),
        LearnedRational(1, ("mu",)),
        (jnp.array([2.0]), jnp.array([1.0, 0.0, -2.0])),
    )
    found = module.smallest_denominator([(0.0, 1.0)])
    assert (found.value, found.place) == (pytest.approx(-1.0), (1.0,))
    assert float(module.denominator(mu=0.5)) == 0.5


def test_a_learned_rational_is_for_the_tables_coordinates(make_table, unit_axis):
    table = make_table(lambda mu: mu, unit_axis("mu", 8))
    with pytest.raises(EcfitError, match="is a function of r: the table has mu"):
        ecfit.fit(table, LearnedRational(1, ("r",)))
    with pytest.raises(EcfitError, match="too many terms"):
        LearnedRational(20, ("a", "b", "c", "d"))


def test_weights_move_a_fit_to_where_they_are(make_table, axes):
    table = make_table(lambda r, mu: 1.0 / (1.0 + r * r + mu) ** 2, *axes)
    near, far = (ecfit.fit(table, ecfit.Rational(1), weights={"mu": p}) for p in (0, 8))
    place = np.abs(near.approximation.on_grid([np.ones(1), np.ones(1)]) - 1.0 / 9.0)
    assert np.abs(far.approximation.on_grid([np.ones(1), np.ones(1)]) - 1.0 / 9.0) < 0.5 * place
    assert far.rmse > near.rmse


def test_a_monotone_fit_does_not_fall(make_table, unit_axis):
    """The truth has a dip, which a free fit follows."""
    table = make_table(lambda mu: 0.5 + 0.3 * mu + 0.08 * np.cos(9.0 * mu), unit_axis("mu", 30))
    free = ecfit.fit(table, ecfit.Polynomial(5))
    fit = ecfit.fit(table, ecfit.Polynomial(5), monotone={"mu": 1})
    assert np.diff(free.approximation.on_grid(GRID[:1])).min() < -1e-3
    assert np.diff(fit.approximation.on_grid(GRID[:1])).min() > -2e-4
    assert free.rmse < fit.rmse < 0.06


def test_monotone_in_another_view_and_the_other_direction(make_table, axes):
    table = make_table(lambda r, mu: 0.6 + 0.1 * np.cos(6.0 * r) + 0.1 * mu, *axes)
    fit = ecfit.fit(table, ecfit.Polynomial(4), monotone={"alpha": -1})
    nodes = dict(zip(fit.approximation.variables, GRID, strict=True))
    along = fit.approximation.variables.index("alpha")
    assert set(nodes) == {"mu", "alpha"}
    assert np.diff(fit.approximation.on_grid(GRID), axis=along).max() < 2e-3


def test_a_direction_that_the_truth_leaves_halfway_flattens_the_fit(make_table, unit_axis):
    """What the penalty held is monotone, and said to have converged; what it could not hold is neither."""
    table = make_table(lambda mu: 0.5 + 0.3 * np.sin(6.0 * mu), unit_axis("mu", 30))
    fit = ecfit.fit(table, ecfit.Polynomial(5), monotone={"mu": 1})
    assert fit.ok
    assert np.diff(fit.approximation.on_grid(GRID[:1])).min() > -1e-5
    assert fit.max_error > 0.2
    hasty = ecfit.fit(table, ecfit.Polynomial(5), monotone={"mu": 1}, max_steps=1)
    assert hasty.status == "not-converged"


@pytest.mark.parametrize(
    ("monotone", "message"),
    [
        ({"F0": 1}, "no coordinate 'F0': its axes are r, mu"),
        ({"mu": 2}, "mu needs 1"),
        ({"r": 1, "alpha": -1}, "contradicts itself: 'alpha' is another view of 'r'"),
        ("mu", "maps coordinates"),
    ],
)
def test_directions_that_make_no_sense_are_told(make_table, axes, monotone, message):
    table = make_table(lambda r, mu: 0.5 + 0.0 * mu, *axes)
    with pytest.raises(EcfitError, match=message):
        ecfit.fit(table, ecfit.Rational(1), monotone=monotone)
