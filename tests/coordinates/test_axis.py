"""Axes: nodes, nominal coordinates and the mistakes that they refuse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.coordinates import MAPS, SPACINGS, Axis
from ecfit.errors import EcfitError

COUNTED = sorted(set(SPACINGS) - {"given"})


@given(
    count=st.integers(2, 60),
    low=st.floats(0.0, 10.0),
    width=st.floats(1e-3, 10.0),
    spacing=st.sampled_from(["uniform", "gauss", "chebyshev"]),
    through=st.sampled_from(["identity", "square", "sqrt", "fourth-power"]),
)
def test_nodes_increase_within_their_range(count, low, width, spacing, through):
    axis = Axis.spaced("r", count, low, low + width, spacing, through)
    assert len(axis) == count
    assert (axis.low, axis.high) == (low, low + width)
    assert np.all(np.diff(axis.nodes) > 0.0)
    assert low <= axis.nodes[0]
    assert axis.nodes[-1] <= low + width
    np.testing.assert_array_equal(axis.nominal, axis.nodes)
    assert not axis.clamped


@pytest.mark.parametrize("through", ["identity", "square", "sqrt", "fourth-power"])
@pytest.mark.parametrize("spacing", ["uniform", "chebyshev"])
def test_ends_are_exact_whatever_the_map_rounds(spacing, through):
    axis = Axis.spaced("r", 7, 0.1, 0.7, spacing, through)
    assert (axis.nodes[0], axis.nodes[-1]) == (0.1, 0.7)


@pytest.mark.parametrize("through", ["square", "sqrt", "fourth-power"])
def test_nodes_are_equally_spaced_in_the_maps_argument(through):
    t = MAPS[through].inverse(Axis.spaced("r", 9, 0.2, 0.9, through=through).nodes)
    np.testing.assert_allclose(np.diff(t), (t[-1] - t[0]) / 8, rtol=1e-12)


def test_an_axis_of_indices_may_be_spaced_in_F0():
    ior = Axis.spaced("ior", 5, 1.0, 3.0, through="F0-to-ior")
    np.testing.assert_allclose(MAPS["F0-to-ior"].inverse(ior.nodes), np.linspace(0.0, 0.25, 5), atol=1e-15)


@pytest.mark.parametrize("count", [2, 5, 16])
def test_gauss_nodes_are_exact_up_to_degree_2n_minus_1_and_no_further(count):
    axis = Axis.spaced("mu", count, 0.0, 1.0, "gauss")
    # The weights that make these nodes exact for degrees below n; Gauss nodes are exact far beyond. In
    # Legendre polynomials, where the system is well conditioned.
    degrees = np.arange(count)
    basis = np.polynomial.legendre.legvander(2.0 * axis.nodes - 1.0, 2 * count)
    weights = np.linalg.solve(basis[:, :count].T, 1.0 * (degrees == 0))
    integrals = weights @ basis
    np.testing.assert_allclose(integrals[1 : 2 * count], 0.0, atol=1e-13)
    assert abs(integrals[2 * count]) > 0.1


@pytest.mark.parametrize("count", [2, 3, 9])
def test_chebyshev_nodes_are_the_extrema_of_a_chebyshev_polynomial(count):
    x = 2.0 * Axis.spaced("mu", count, 0.0, 1.0, "chebyshev").nodes - 1.0
    value = np.polynomial.chebyshev.Chebyshev.basis(count - 1)(x)
    np.testing.assert_allclose(value, (-1.0) ** np.arange(count - 1, -1, -1), atol=1e-13)


def test_a_clamped_axis_integrates_at_clipped_nodes_and_shows_fits_the_unit_interval():
    axis = Axis.spaced("mu", 32, 0.02, 1.0, "clamped")
    np.testing.assert_array_equal(axis.nominal, np.linspace(0.0, 1.0, 32))
    assert axis.nodes[0] == 0.02
    np.testing.assert_array_equal(axis.nodes[1:], np.linspace(0.0, 1.0, 32)[1:])
    assert (axis.low, axis.high) == (0.0, 1.0)
    assert axis.clamped


def test_nodes_below_the_clamp_repeat_but_nominal_coordinates_do_not():
    axis = Axis.spaced("r", 11, 0.25, 0.85, "clamped")
    np.testing.assert_array_equal(axis.nodes[:3], 0.25)
    np.testing.assert_array_equal(axis.nodes[-2:], 0.85)
    assert np.all(np.diff(axis.nominal) > 0.0)


def test_given_nodes_are_kept_as_they_are():
    nodes = [0.1, 0.2, 0.7]
    axis = Axis.given("r", nodes)
    np.testing.assert_array_equal(axis.nodes, nodes)
    assert (axis.low, axis.high) == (0.1, 0.7)


def test_nodes_cannot_be_changed_afterwards():
    source = np.array([0.1, 0.2])
    axis = Axis.given("r", source)
    source[0] = 5.0
    assert axis.nodes[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        axis.nodes[0] = 5.0


@pytest.mark.parametrize("count", [1, 0, -3, 2.0, "8", None, True, 2**24 + 1, 10**20])
@pytest.mark.parametrize("spacing", COUNTED)
def test_a_count_must_be_an_integer_of_two_or_more_that_fits_a_memory(spacing, count):
    with pytest.raises(EcfitError, match="axis 'mu': count"):
        Axis.spaced("mu", count, spacing=spacing)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        (1.0, 0.0),
        (0.5, 0.5),
        (0.0, np.inf),
        (np.nan, 1.0),
        (0.0, np.nan),
        ("a", 1.0),
        (0, 10**400),
        (None, 1.0),
    ],
)
def test_a_range_must_be_finite_and_not_empty(low, high):
    with pytest.raises(EcfitError, match="axis 'mu'"):
        Axis.spaced("mu", 4, low, high)


@pytest.mark.parametrize(("low", "high"), [(-0.1, 1.0), (0.0, 1.1)])
def test_a_clamped_axis_lies_in_the_unit_interval(low, high):
    with pytest.raises(EcfitError, match="clamped"):
        Axis.spaced("mu", 4, low, high, "clamped")


def test_a_clamped_axis_takes_no_map():
    with pytest.raises(EcfitError, match="no map"):
        Axis.spaced("mu", 4, 0.1, 1.0, "clamped", "square")


@pytest.mark.parametrize("through", ["square", "sqrt", "fourth-power", "F0-to-ior"])
def test_a_range_outside_the_map_is_refused(through):
    with pytest.raises(EcfitError, match="map"):
        Axis.spaced("mu", 4, -1.0, 1.0, through=through)


def test_an_unknown_spacing_lists_the_known_ones_and_suggests():
    with pytest.raises(EcfitError, match=r"expected one of .*uniform.*did you mean 'uniform'"):
        Axis.spaced("mu", 4, spacing="unifrom")


@pytest.mark.parametrize("through", ["squre", "", [], None])
def test_an_unknown_map_is_refused(through):
    with pytest.raises(EcfitError, match="unknown map"):
        Axis.spaced("mu", 4, through=through)


@pytest.mark.parametrize("kind", ["spacing", "map"])
@pytest.mark.parametrize("given", [{}, None, "squre"])
def test_an_axis_read_from_a_file_names_what_is_known(kind, given):
    words = {"spacing": "given", "through": "identity"} | {"through" if kind == "map" else kind: given}
    with pytest.raises(EcfitError, match=f"unknown {kind}"):
        Axis("mu", np.array([0.0, 1.0]), np.array([0.0, 1.0]), **words)


def test_given_spacing_needs_nodes():
    with pytest.raises(EcfitError, match="nodes"):
        Axis.spaced("mu", 4, spacing="given")


@pytest.mark.parametrize(
    "nodes",
    [
        [],
        [0.5],
        [0.1, 0.1],
        [0.2, 0.1],
        [0.1, np.nan],
        [0.1, np.inf],
        [[0.1, 0.2]],
        [[0.1, 0.2], [0.3]],
        ["a", "b"],
        "ab",
        None,
        {0.1, 0.2},
        [object(), object()],
        3.0,
    ],
)
def test_bad_nodes_are_refused(nodes):
    with pytest.raises(EcfitError, match="axis 'r'"):
        Axis.given("r", nodes)


@pytest.mark.parametrize("name", ["", 3, None])
def test_an_axis_needs_a_name(name):
    with pytest.raises(EcfitError, match="name"):
        Axis.given(name, [0.0, 1.0])


def test_nodes_and_nominal_coordinates_must_match():
    with pytest.raises(EcfitError, match="differ in number"):
        Axis("r", np.array([0.0, 1.0]), np.array([0.0, 0.5, 1.0]))


@pytest.mark.parametrize("spacing", COUNTED)
def test_the_description_names_what_a_reader_needs(spacing):
    line = Axis.spaced("mu", 12, 0.25, 0.75, spacing).describe()
    for part in ("mu", "12", spacing, "0.25", "0.75"):
        assert part in line
