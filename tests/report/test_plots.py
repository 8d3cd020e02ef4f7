"""Plots: each on the axes that it is given, which it returns, showing the numbers of the table."""

import dataclasses

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import ecfit
from ecfit.errors import EcfitError
from ecfit.metrics import measure, predict, signed_error
from ecfit.report import plot_error, plot_error_against_cost, plot_error_along, plot_slice, plot_table


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


@pytest.fixture(scope="module")
def table(make_smooth) -> ecfit.Table:
    return make_smooth(5, 6, 7)


@pytest.fixture(scope="module")
def fit(table) -> ecfit.Fit:
    return ecfit.fit(table, ecfit.Polynomial(1))


def mesh_of(axes: Axes) -> np.ndarray:
    (mesh,) = axes.collections
    return np.asarray(mesh.get_array()).reshape(6, 7)


def test_a_plot_returns_the_axes_it_drew_on(axes, table, fit):
    for draw in (
        lambda: plot_table(table, axes=axes),
        lambda: plot_error(fit, table, axes=axes),
        lambda: plot_slice(table, fit, axes=axes),
        lambda: plot_error_along([fit], table, "mu", axes=axes),
        lambda: plot_error_against_cost(table, [fit], axes=axes),
    ):
        assert draw() is axes


def test_without_axes_there_is_a_new_figure(make_smooth):
    matplotlib.use("agg")
    from matplotlib import pyplot

    try:
        first, second = (plot_table(make_smooth(5)) for _ in range(2))
        assert first.figure is not second.figure
        assert pyplot.get_fignums() == [1, 2]
    finally:
        pyplot.close("all")


def test_a_table_is_cut_where_it_is_asked_for_and_else_in_the_middle(table):
    np.testing.assert_array_equal(mesh_of(plot_table(table, axes=Figure().add_subplot())), table.values[2])
    cut = plot_table(table, at={"F0": 0.8}, axes=Figure().add_subplot())
    np.testing.assert_array_equal(mesh_of(cut), table.values[3])
    assert cut.get_title() == "F0 = 0.75"
    assert (cut.get_xlabel(), cut.get_ylabel()) == ("mu", "r")


def test_an_error_has_a_scale_that_is_symmetric_about_0(axes, table, fit):
    plot_error(fit, table, axes=axes)
    error = signed_error(fit.approximation, table)[2]
    np.testing.assert_array_equal(mesh_of(axes), error)
    low, high = axes.collections[0].get_clim()
    assert -low == high == np.abs(error).max()


def test_a_slice_has_the_truth_and_the_fit(axes, table, fit):
    plot_slice(table, fit, along="r", at={"F0": 0.0, "mu": 1.0}, axes=axes)
    truth, ours = axes.get_lines()
    np.testing.assert_array_equal(truth.get_ydata(), table.values[0, :, -1])
    np.testing.assert_array_equal(ours.get_ydata(), predict(fit.approximation, table)[0, :, -1])
    assert ours.get_label() == "polynomial 1"
    assert axes.get_xlabel() == "r"


def test_a_slice_that_is_left_open_has_five_curves(axes, table):
    plot_slice(table, axes=axes)
    lines = axes.get_lines()
    assert [line.get_label() for line in lines] == [f"r = {x:.3g}" for x in (0.0, 0.2, 0.4, 0.8, 1.0)]
    np.testing.assert_array_equal(lines[-1].get_ydata(), table.values[2, -1])


def test_errors_along_an_axis_are_means_and_maxima_over_the_others(axes, table, fit):
    plot_error_along([fit], table, "r", axes=axes)
    error = np.abs(signed_error(fit.approximation, table))
    mean, most = axes.get_lines()
    np.testing.assert_allclose(mean.get_ydata(), error.mean(axis=(0, 2)))
    np.testing.assert_allclose(most.get_ydata(), error.max(axis=(0, 2)))


@pytest.mark.parametrize("by", ["coefficients", "operations"])
def test_error_against_cost_has_fits_published_and_tables(axes, table, fit, by):
    other = ecfit.Table(table.values + 0.01, table.errors, table.status, table.axes, table.contract, 1e-8)
    lookup = ecfit.Approximation.lookup(other)
    worse = fit.approximation.with_quotient(values=fit.approximation.coefficients + 0.1)
    worse = dataclasses.replace(worse, source="a paper")
    plot_error_against_cost(table, [fit, worse, lookup], by=by, axes=axes)
    lines = {line.get_label(): line for line in axes.get_lines()}
    tables = ["look-up tables"] if by == "coefficients" else []  # they fetch, and do not calculate
    assert list(lines) == ["polynomial", "published", *tables]
    (x,), (y,) = lines["published"].get_data()
    assert (x, y) == (4 if by == "coefficients" else 3, measure(worse, table).rmse)


def test_other_coordinates_are_refused_with_the_names_that_there_are(table, fit):
    for draw in (
        lambda: plot_table(table, at={"ior": 1.5}),
        lambda: plot_slice(table, fit, along="ior"),
        lambda: plot_error_along([fit], table, "ior"),
    ):
        with pytest.raises(EcfitError, match="unknown axis 'ior': expected one of F0, mu, r"):
            draw()
    with pytest.raises(EcfitError, match="is an axis of the image"):
        plot_table(table, at={"mu": 0.5})
