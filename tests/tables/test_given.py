"""`Table.from_array`: somebody's own numbers become a table, or one clear error."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ecfit
from ecfit import Axis, Contract, EcfitError, Table
from ecfit.quadrature import Status

UNKNOWN = {"model": "unknown"}
# 3 x 4: falls with roughness, rises with mu, as E does.
VALUES = np.array([[0.97, 0.98, 0.99, 1.0], [0.8, 0.85, 0.9, 0.95], [0.3, 0.4, 0.5, 0.6]])


def test_an_array_and_names_of_spacings_make_a_table():
    table = Table.from_array(VALUES, {"r": "uniform", "mu": "texel-centre"}, UNKNOWN)
    np.testing.assert_array_equal(table.values, VALUES)
    np.testing.assert_array_equal(table.axes[0].nodes, [0.0, 0.5, 1.0])
    np.testing.assert_array_equal(table.axes[1].nodes, [0.125, 0.375, 0.625, 0.875])
    assert (table.axes[1].low, table.axes[1].high) == (0.0, 1.0)
    assert table.contract == Contract("unknown")


@pytest.mark.parametrize(
    "r", [3, [0.0, 0.5, 1.0], np.linspace(0, 1, 3), Axis.spaced("r", 3), Axis.given("r", [0.0, 0.5, 1.0])]
)
def test_an_axis_may_be_given_in_any_way(r):
    table = Table.from_array(VALUES.tolist(), {"r": r, "mu": 4}, Contract("conductor"))
    np.testing.assert_array_equal(table.axes[0].nodes, [0.0, 0.5, 1.0])


def test_the_table_is_a_copy():
    values = VALUES.copy()
    table = Table.from_array(values, {"r": 3, "mu": 4}, UNKNOWN)
    values[0, 0] = 7.0
    assert table.values[0, 0] == 0.97


@pytest.mark.parametrize("dtype", ["uint16", "float16", "float32", "int64", ">f4"])
def test_all_real_types_become_float64(dtype):
    table = Table.from_array(np.ones((2, 2), dtype), {"r": 2, "mu": 2}, UNKNOWN)
    assert table.values.dtype == np.float64
    np.testing.assert_array_equal(table.values, 1.0)


def test_one_minus_e_in_whole_numbers_is_converted():
    stored = np.round((1.0 - VALUES) * 65535).astype(np.uint16)
    table = Table.from_array(stored, {"r": 3, "mu": 4}, UNKNOWN, stored="1-E", scale=65535)
    np.testing.assert_allclose(table.values, VALUES, atol=0.5 / 65535)
    assert table.contract.stored == "E"
    said = Table.from_array(stored, {"r": 3, "mu": 4}, {"stored": "1-E"}, scale=65535)
    np.testing.assert_array_equal(said.values, table.values)


@given(values=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_converting_twice_gives_the_numbers_back(values):
    axes = {"r": 2, "mu": 2}
    array = np.reshape(values, (2, 2))
    once = Table.from_array(array, axes, UNKNOWN, stored="1-E").values
    again = Table.from_array(once, axes, UNKNOWN, stored="1-E").values
    np.testing.assert_allclose(again, array, atol=2e-16)


def test_unknown_errors_stay_unknown(tmp_path):
    table = Table.from_array(VALUES, {"r": 3, "mu": 4}, UNKNOWN, source="theirs.h")
    assert np.isnan(table.errors).all()
    assert not table.estimated
    assert table.counts()[Status.GIVEN] == VALUES.size
    text = "\n".join(table.describe())
    assert "given, not integrated here: no error estimate (source: theirs.h)" in text
    assert "nan" not in text
    assert "WARNING" not in text
    table.save(tmp_path / "t.npz")
    again = Table.load(tmp_path / "t.npz")
    assert again.describe() == table.describe()
    assert np.isnan(again.tolerance)
    assert again.provenance == table.provenance


def test_known_errors_are_kept_and_held_against_the_tolerance():
    errors = np.full(VALUES.shape, 1e-6)
    errors[1, 2] = 1e-3
    table = Table.from_array(VALUES, {"r": 3, "mu": 4}, UNKNOWN, errors, 1e-5)
    assert table.counts()[Status.TOLERANCE_NOT_MET] == 1
    assert table.counts()[Status.GIVEN] == VALUES.size - 1
    assert "largest error estimate 0.001 (tolerance 1e-05)" in table.describe()
    one = Table.from_array(VALUES, {"r": 3, "mu": 4}, UNKNOWN, 1e-4)
    assert "largest error estimate 0.0001" in one.describe()


def test_the_key_is_that_of_the_content():
    axes = {"r": 3, "mu": 4}
    key = Table.from_array(VALUES, axes, UNKNOWN).provenance["key"]
    same = Table.from_array(VALUES.tolist(), axes, Contract("unknown"), source="elsewhere")
    assert same.provenance["key"] == key
    others = [
        Table.from_array(VALUES + 1e-16 + 1e-15, axes, UNKNOWN),
        Table.from_array(VALUES, {"r": "texel-centre", "mu": 4}, UNKNOWN),
        Table.from_array(VALUES, {"alpha": 3, "mu": 4}, UNKNOWN),
        Table.from_array(VALUES, axes, {"lobe": "reflection"}),
        Table.from_array(VALUES, axes, UNKNOWN, 1e-3),
        Table.from_array(VALUES, axes, UNKNOWN, None, 1e-3),
    ]
    assert len({key, *(t.provenance["key"] for t in others)}) == 7


def test_a_clamped_axis_is_said_in_the_contract():
    clamped = Axis.spaced("r", 3, 0.1, 1.0, "clamped")
    assert Table.from_array(VALUES, {"r": clamped, "mu": 4}, UNKNOWN).contract.sampling == "clamped"


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (VALUES.T, r"shape \(4, 3\), the axes say r = 3, mu = 4 \(transpose them\?\)"),
        (VALUES[:2], r"shape \(2, 4\)"),
        (VALUES.ravel(), "1 dimensions.*2 axes"),
        (0.5, "0 dimensions"),
        ([[1, 2, 3, 4], [1, 2]], "rows have one length"),
        (VALUES.astype(str), "real numbers"),
        (VALUES > 0.5, "real numbers"),
        (VALUES + 0j, "real numbers"),
        (VALUES.astype(object), "real numbers"),
        (None, "real numbers"),
        ({"a": 1}, "real numbers"),
        (np.where(VALUES == 0.9, np.nan, VALUES), "1 of 12 values are NaN.*r = 0.5, mu = 0.6667"),
        (np.where(VALUES == 0.9, np.inf, VALUES), "NaN or infinite"),
        (np.ma.masked_greater(VALUES, 0.9), "masked"),
    ],
)
def test_what_is_no_table_of_numbers_is_refused(values, words):
    with pytest.raises(EcfitError, match=words):
        Table.from_array(values, {"r": 3, "mu": 4}, UNKNOWN)


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"r": [1.0, 0.5, 0.0], "mu": 4}, "axis 'r': nodes must increase"),
        ({"r": [0.0, np.nan, 1.0], "mu": 4}, "finite"),
        ({"r": "centre", "mu": 4}, "unknown spacing 'centre'.*texel-centre"),
        ({"r": "given", "mu": 4}, "needs its nodes"),
        ({"ior": 3, "mu": 4}, "axis 'ior' has no range.*low and high"),
        ({"r": 3, "mu": [0.0, 30.0, 60.0, 90.0]}, r"mu' spans \[0, 90\], outside \[0, 1\]"),
        ({"r": [-0.5, 0.0, 1.0], "mu": 4}, "outside"),
        ({"r": 3, "alpha": 4}, "'r' and 'alpha' are the same coordinate"),
        ({"r": Axis.spaced("mu", 3), "mu": 4}, "axis 'mu' given under the name 'r'"),
        ({"r": True, "mu": 4}, "axis 'r'"),
        ({"r": {}, "mu": 4}, "axis 'r'"),
        ({3: 3, "mu": 4}, "axis"),
        ([3, 4], "axes must be a mapping"),
        ({}, "axes must be a mapping"),
    ],
)
def test_bad_axes_are_refused(axes, words):
    with pytest.raises(EcfitError, match=words):
        Table.from_array(VALUES, axes, UNKNOWN)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"contract": "conductor"}, "mapping such as"),
        ({"contract": None}, "mapping such as"),
        ({"contract": {"quantty": "x"}}, "did you mean 'quantity'"),
        ({"contract": {"stored": "2-E"}}, "unknown stored value '2-E'"),
        ({"contract": {"stored": []}}, "unknown stored value"),
        ({"contract": {"stored": "E"}, "stored": "1-E"}, "leave one of them out"),
        ({"stored": "1 - E"}, "expected one of 1-E, E"),
        ({"scale": 0}, "stands for 1"),
        ({"scale": float("nan")}, "stands for 1"),
        ({"scale": "65535"}, "stands for 1"),
        ({"errors": -1e-9}, "0 or more"),
        ({"errors": np.nan}, "leave them out"),
        ({"errors": np.zeros(3)}, r"errors have shape \(3,\)"),
        ({"tolerance": 0.0}, "positive"),
        ({"tolerance": "x"}, "positive"),
    ],
)
def test_bad_settings_are_refused(settings, words):
    with pytest.raises(EcfitError, match=words):
        Table.from_array(VALUES, {"r": 3, "mu": 4}, **{"contract": UNKNOWN, **settings})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (VALUES * 100, "reach 100.*scale"),
        (np.round(VALUES * 65535).astype(int), "whole numbers"),
        (VALUES - 0.5, "fall to -0.2.*not negative"),
        (1.0 - VALUES, "as 1 - E does.*stored = '1-E'"),
    ],
)
def test_what_looks_like_another_convention_is_hinted_not_guessed(values, words):
    table = Table.from_array(values, {"r": 3, "mu": 4}, UNKNOWN)
    np.testing.assert_array_equal(table.values, values)
    (remark,) = table.remarks()
    assert f"WARNING: {remark}" in table.describe()
    assert re.search(words, remark)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("conductor", {"masking": "height-correlated"}),
        ("dielectric", {"ior": 1.5}),
        ("conductor", {"fresnel": "schlick", "F0": 0.04}),
    ],
)
def test_no_hint_for_the_albedo_of_a_model(name, options):
    """Whatever conventions: our own numbers, handed in as somebody's, look right."""
    axes = {"r": [0.1, 0.5, 1.0], "mu": [0.1, 0.6, 1.0]}
    ours = ecfit.tabulate(ecfit.model(name, **options), axes, tolerance=1e-3)
    assert ours.remarks() == []
    theirs = Table.from_array(ours.values, axes, ours.contract)
    assert theirs.remarks() == []
    swapped = Table.from_array(ours.values.T, dict(reversed(axes.items())), ours.contract)
    assert swapped.remarks() == []


def test_radiance_and_other_quantities_may_exceed_1():
    for contract in ({"transport": "radiance"}, {"quantity": "schlick-a"}):
        assert Table.from_array(VALUES * 5, {"r": 3, "mu": 4}, contract).remarks() == []


def test_a_given_table_is_fitted_like_ours():
    r, mu = np.linspace(0, 1, 6), (np.arange(8) + 0.5) / 8
    values = 1.0 - 0.3 * r[:, None] ** 2 + 0.1 * r[:, None] * mu
    fit = ecfit.fit(Table.from_array(values, {"r": 6, "mu": "texel-centre"}, UNKNOWN), ecfit.Polynomial(2))
    assert fit.ok
    assert fit.max_error < 1e-12
    assert fit.approximation.contract.model == "unknown"
    assert float(fit(mu=0.0, alpha=1.0)) == pytest.approx(0.7)
