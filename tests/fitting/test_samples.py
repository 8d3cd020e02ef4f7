"""What a structured fit sees of a table: coordinates, weights, and guards on the closed domain."""

import numpy as np
import pytest

from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.fitting.samples import check_coordinates, guard_points, table_points, weights_of


@pytest.mark.parametrize("through", ["identity", "square"])
def test_weights_are_a_mean(through: str):
    gauss = Axis.spaced("mu", 9, 0.0, 1.0, "gauss", through)
    weights = weights_of(gauss)
    assert weights.sum() == pytest.approx(1.0, abs=1e-14)
    # The mean over the axis's own map: exact for polynomials of it.
    t = gauss.nodes if through == "identity" else np.sqrt(gauss.nodes)
    assert weights @ t**5 == pytest.approx(1.0 / 6.0, abs=1e-14)
    assert weights_of(Axis.spaced("mu", 4)).tolist() == [0.25] * 4


def test_every_entry_has_its_coordinates_and_weight(make_table):
    axes = Axis.spaced("r", 4), Axis.spaced("mu", 3, 0.0, 1.0, "gauss"), Axis.spaced("ior", 2, 1.0, 2.0)
    table = make_table(lambda r, mu, ior: r + 10.0 * mu + 100.0 * ior, *axes)
    points, weights = table_points(table)
    assert set(points) == {"alpha", "mu", "ior", "F0"}
    np.testing.assert_allclose(
        np.sqrt(points["alpha"]) + 10.0 * points["mu"] + 100.0 * points["ior"], table.values.ravel()
    )
    np.testing.assert_allclose(points["F0"], ((points["ior"] - 1.0) / (points["ior"] + 1.0)) ** 2, atol=1e-15)
    assert weights.sum() == pytest.approx(1.0)
    at = weights.reshape(table.values.shape)
    np.testing.assert_allclose(at[2, :, 1], weights_of(axes[1]) / 8.0)


@pytest.mark.parametrize("names", [("rho", "mu"), ("mu", "rho")])
def test_an_axis_that_no_form_knows_is_told(make_table, names):
    table = make_table(lambda a, b: a, *(Axis.spaced(n, 3) for n in names))
    with pytest.raises(
        EcfitError, match="axis 'rho' is no coordinate of structured forms: mu, alpha, F0, ior"
    ):
        table_points(table)


@pytest.mark.parametrize(
    ("variables", "axes", "fits"),
    [
        (("mu", "alpha"), ("r", "mu"), True),
        (("mu", "alpha"), ("mu", "alpha"), True),
        (("F0",), ("ior",), True),
        (("mu", "alpha"), ("mu",), False),
        (("mu",), ("r", "mu"), False),
        (("F0", "ior"), ("ior",), False),
        (("F0",), ("mu",), False),
    ],
)
def test_variables_and_axes_correspond(variables, axes, fits: bool):
    made = [Axis.spaced(n, 3, 1.0, 2.0) if n == "ior" else Axis.spaced(n, 3) for n in axes]
    if fits:
        check_coordinates(variables, made)
        return
    with pytest.raises(EcfitError) as caught:
        check_coordinates(variables, made)
    assert f"function of {', '.join(variables)}, the table of {', '.join(axes)}" in str(caught.value)


def test_guards_cover_the_closed_domain_and_every_direction_at_its_corner():
    domain = {"mu": (0.0, 1.0), "alpha": (0.0, 1.0), "F0": (0.02, 0.3)}
    points = guard_points(domain)
    for name, (low, high) in domain.items():
        assert points[name].min() == pytest.approx(low, abs=1e-15)
        assert points[name].max() == pytest.approx(high)
    rho = points["mu"] + points["alpha"]
    assert rho.min() > 0.0
    for f0 in domain["F0"]:
        near = (rho < 1e-9) & np.isclose(points["F0"], f0)
        t = np.unique((points["alpha"] / rho)[near])
        assert t[0] == 0.0
        assert t[-1] == pytest.approx(1.0)
        assert np.diff(t).max() < 0.05
    # Every corner of the box but alpha = mu = 0.
    for mu, alpha in ((0.0, 1.0), (1.0, 0.0), (1.0, 1.0)):
        assert np.any((points["mu"] == mu) & (points["alpha"] == alpha))


def test_guards_of_one_coordinate():
    (mu,) = guard_points({"mu": (0.0, 1.0)}).values()
    assert (mu[0], mu[-1]) == (0.0, 1.0)
    assert np.all(np.diff(mu) > 0.0)
