"""Slices and maps: what a page is given is what the table and the approximation say."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

import ecfit
from ecfit.metrics import measure, signed_error
from ecfit.report.entries import entries
from ecfit.report.maps import image, maps
from ecfit.report.slices import slices


def unpacked(text: str, low: float, high: float) -> np.ndarray:
    return low + (high - low) * np.frombuffer(base64.b64decode(text), "<u2") / 65534.0


@pytest.mark.parametrize("counts", [(50,), (50, 50), (30, 20, 50)])
def test_truth_and_errors_come_back_to_a_part_in_65534(make_smooth, counts: tuple[int, ...]):
    table = make_smooth(*counts)
    fit = ecfit.fit(table, ecfit.Polynomial(1))
    found = slices(table, entries(table, [fit]))
    shape = [len(a["at"]) for a in found["axes"]]
    assert shape == [11, 5, 41][-len(counts) :]
    picks = [
        [int(np.argmin(np.abs(axis.nominal - x))) for x in a["at"]]
        for axis, a in zip(table.axes, found["axes"], strict=True)
    ]
    truth = unpacked(found["truth"], found["low"], found["high"]).reshape(shape)
    np.testing.assert_allclose(truth, table.values[np.ix_(*picks)], atol=(found["high"] - found["low"]) / 1e5)
    series = found["series"][0]
    error = unpacked(series["error"], -series["bound"], series["bound"]).reshape(shape)
    expected = signed_error(fit.approximation, table)[np.ix_(*picks)]
    np.testing.assert_allclose(error, expected, atol=series["bound"] / 3e4)


def test_what_is_not_a_number_is_marked(make_smooth):
    table = make_smooth(4, 5)
    values = table.values.copy()
    values[1, 2] = np.nan
    damaged = ecfit.Table(values, table.errors, table.status, table.axes, table.contract, 1e-8)
    raw = np.frombuffer(base64.b64decode(slices(damaged, [])["truth"]), "<u2")
    assert np.flatnonzero(raw == 65535).tolist() == [1 * 5 + 2]


def test_at_most_six_approximations_are_shown(make_smooth):
    table = make_smooth(4, 5)
    a = ecfit.Approximation.lookup(table)
    assert len(slices(table, entries(table, [], [(a, measure(a, table))] * 9))["series"]) == 6


def test_four_dimensions_have_two_sliders_within_the_same_room():
    axes = tuple(ecfit.Axis.spaced(n, 12) for n in ("x", "F0", "r", "mu"))
    values = np.zeros((12,) * 4)
    table = ecfit.Table(values, values, values, axes, ecfit.Contract("synthetic"), 1e-8)
    shape = [len(a["at"]) for a in slices(table, [])["axes"]]
    assert shape == [4, 4, 5, 12]


def test_a_map_is_red_where_the_fit_is_too_high_and_its_last_axis_runs_to_the_right(make_table, unit_axis):
    """Zero against (mu - 1/2) at r = 1, of the opposite sign at r = 0."""
    table = make_table(lambda r, mu: (2.0 * r - 1.0) * (mu - 0.5), unit_axis("r", 9), unit_axis("mu", 9))
    zero = ecfit.fit(table, ecfit.Polynomial(1)).approximation
    zero = zero.with_quotient(values=np.zeros(3))
    found = maps(table, entries(table, [], [(zero, measure(zero, table))]))
    assert found is not None
    (one,) = found.maps
    assert one.bound == pytest.approx(0.5)
    picture = Image.open(io.BytesIO(base64.b64decode(one.source.partition(",")[2]))).convert("RGB")
    width, height = picture.size
    top_left = picture.getpixel((0, 0))
    assert isinstance(top_left, tuple)
    assert top_left[0] > 90 > top_left[2]  # at r = 1, mu = 0 the table is -1/2: 0 is too high, red
    for corner in ((width - 1, 0), (0, height - 1)):
        other = picture.getpixel(corner)
        assert isinstance(other, tuple)
        assert other[2] > 90 > other[0]
    assert picture.getpixel((width - 1, height - 1)) == top_left
    assert (found.across, found.up, found.where) == ("mu 0 to 1", "r 0 to 1", "")


def test_an_exact_approximation_has_a_white_map(make_smooth):
    address = image(np.zeros((4, 5)), 0.0)
    picture = Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2]))).convert("RGB")
    ((_, pixel),) = picture.getcolors() or []
    assert isinstance(pixel, tuple)
    assert min(pixel) > 240
    assert maps(make_smooth(4), []) is None  # of one dimension there are no maps
