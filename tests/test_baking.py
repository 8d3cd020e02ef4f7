"""Tables on a consumer's nodes: from a model, from fits, from tables; what does not fit is told."""

from contextlib import contextmanager

import numpy as np
import pytest

import ecfit
from ecfit import Axis, EcfitError, Table, bake
from ecfit.progress import Progress
from ecfit.tables import LAYOUTS

GIVEN = Table.from_array(np.full((3, 3), 0.5), {"r": 3, "mu": 3}, {"model": "unknown"})


def test_a_model_is_integrated_as_the_consumer_evaluates_it(tmp_path):
    baked = bake("conductor", "cycles", axes={"r": 8, "mu": 8}, tolerance=1e-4)
    (table,) = baked.tables
    assert table.contract.options["masking"] == "height-correlated"
    assert table.names == ("mu", "r")
    assert table.axes[0].nodes[0] == 1e-4
    assert baked.remarks() == []
    # Normal incidence at alpha = 1: 1 - ln 2 for both maskings (NumPy's own logarithm).
    assert table.values[-1, -1] == pytest.approx(1.0 - np.log(2.0), abs=1e-4)
    written = baked.save(tmp_path / "t.h")
    assert written.shape == (8, 8)
    assert np.abs(ecfit.read_layout(tmp_path / "t.h").values - table.values).max() <= written.bound


def test_fits_fill_the_channels_of_a_layout():
    names = ["schlick-a-correlated-32", "schlick-b-correlated-16"]
    a, b = bake(names, "three").tables
    assert a.contract.quantity == "schlick-a"
    assert a.provenance["source"] == "schlick-a-correlated-32"
    r = mu = (np.arange(16) + 0.5) / 16
    for table, name in ((a, names[0]), (b, names[1])):
        expected = np.asarray(ecfit.shipped(name)(mu=mu[:, None], r=r[None]))
        np.testing.assert_allclose(table.values, expected, atol=1e-14)


def test_a_fit_on_axes_of_one_s_own():
    axes = {"mu": Axis.spaced("mu", 3, 0.1, 1.0), "r": 4}
    (table,) = bake("conductor-10", axes=axes).tables
    assert table.names == ("mu", "r")
    assert table.values[1, 2] == pytest.approx(float(ecfit.shipped("conductor-10")(mu=0.55, r=2 / 3)))


def test_counts_are_over_the_model_s_own_range_and_progress_is_told():
    told = []

    class Told(Progress):
        @contextmanager
        def stage(self, title, total):
            done = []
            yield done.append
            told.append((title, total, sum(done)))

    axes = {"ior": 2, "mu": [0.2, 0.5, 1.0]}
    settings = {"quantity": "fresnel", "progress": Told()}
    (table,) = bake("dielectric", axes=axes, spacing="texel-centre", **settings).tables
    low, high = ecfit.model("dielectric").parameter_ranges()["ior"]
    assert (table.axes[0].low, table.axes[0].high) == (low, high)
    np.testing.assert_allclose(table.axes[0].nodes, low + (high - low) * np.array([0.25, 0.75]))
    np.testing.assert_array_equal(table.axes[1].nodes, [0.2, 0.5, 1.0])
    assert table.contract.quantity == "fresnel"
    assert told == [("fresnel", 6, 6)]


def test_tables_are_taken_as_they_are_or_refused(tmp_path, make_table, unit_axis):
    table = make_table(lambda r, mu: 0.5 + 0.2 * r * mu, unit_axis("r", 5), unit_axis("mu", 4))
    table.save(tmp_path / "t.npz")
    (same,) = bake(tmp_path / "t.npz").tables
    np.testing.assert_array_equal(same.values, table.values)
    with pytest.raises(EcfitError, match="other nodes of r"):
        bake(table, "mitsuba").save(tmp_path / "t.exr")
    texel = make_table(
        lambda r, mu: r * mu, *(Axis.spaced(n, 3, spacing="texel-centre") for n in ("r", "mu"))
    )
    bake(texel, "mitsuba").save(tmp_path / "t.exr")


def test_nodes_that_the_layout_keeps_from_0_are_not_taken_from_0(tmp_path):
    """At mu = 0 and mu = 1e-4 the albedo of a smooth surface is not the same."""
    table = ecfit.tabulate(
        ecfit.model("conductor", masking="height-correlated"), {"mu": 8, "r": 8}, tolerance=1e-3
    )
    with pytest.raises(EcfitError, match="other nodes of mu"):
        bake(table, "cycles", axes={"mu": 8, "r": 8}).save(tmp_path / "t.h")


def test_what_the_consumer_has_otherwise_is_told():
    (remark,) = bake("conductor-10", "cycles", axes={"r": 3, "mu": 3}).remarks()
    assert "masking = height-correlated, this table separable" in remark


@pytest.mark.parametrize(
    ("sources", "settings", "words"),
    [
        ("nothing", {}, "unknown model, shipped or published fit"),
        ("nothing.npz", {}, "no such table"),
        ("conductor", {}, "no axes of its own"),
        ("conductor-10", {"layout_": "three"}, "takes a model, or 2 tables or fits"),
        (["conductor", "conductor"], {"layout_": "three"}, "one model makes all channels"),
        (
            "conductor-10",
            {"layout_": "cycles", "options": {"masking": "separable"}, "tolerance": 1e-3},
            "fits say themselves what they are of: leave out options, tolerance",
        ),
        ("conductor-10", {"layout_": "cycles", "quantity": "schlick-a"}, "leave out quantity"),
        ("conductor-10", {"layout_": "cycles", "lobe": "all", "transport": "energy"}, "lobe, transport"),
        ("conductor", {"layout_": "three", "quantity": "schlick-a"}, "says what its channels hold"),
        ("conductor", {"layout_": "cycles", "spacing": "uniform"}, "nodes of its own: leave out spacing"),
        (ecfit.model("conductor"), {"layout_": "cycles", "options": {"ndf": "ggx"}}, "has its options"),
        (GIVEN, {"axes": {"r": 3, "mu": 3}}, "a table has its own nodes: leave out axes"),
        (GIVEN, {"spacing": "uniform"}, "leave out spacing"),
        (GIVEN, {"layout_": "yocto", "axes": {"mu": 4}}, "the table has 3 nodes of mu, not 4"),
        ("conductor", {"layout_": "cycles", "axes": {"r": "8"}}, "2 or more, got r = '8'"),
        ("conductor", {"layout_": "cycles", "axes": {"r": 8.0}}, "2 or more, got r = 8.0"),
        ("conductor", {"layout_": "cycles", "axes": {"r": [0.1, 0.2]}}, "2 or more, got r = list"),
        ("conductor", {"layout_": "cycles", "axes": ["r"]}, "axes must be a mapping"),
        ("conductor", {"axes": {"r": "8", "mu": 8}}, "count must be an integer"),
        ("conductor-10", {"axes": {"r": "8", "mu": 8}}, "count must be an integer"),
        ("conductor", {"layout_": "cycles", "axes": {"F0": 3}}, "unknown axis of layout 'cycles'"),
        ("conductor", {"layout_": "cycles", "axes": {"r": 1}}, "2 or more"),
        ("conductor", {"layout_": "cycels"}, "did you mean 'cycles'"),
        ("dielectric-entering-20", {"layout_": "osl-dielectric-front"}, "is made for"),
    ],
)
def test_what_cannot_be_baked_is_told(sources, settings, words):
    with pytest.raises(EcfitError, match=words) as caught:
        bake(sources, **settings)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n, plan in LAYOUTS.items() if plan.axes and plan.model != "unknown"])
def test_every_layout_is_baked_and_passes_its_audit(name, tmp_path):
    """The whole circle: integrate on its nodes, write, read by the layout's name, integrate again."""
    plan = LAYOUTS[name]
    baked = bake(plan.model, name, axes={n.name: 4 for n in plan.axes}, tolerance=1e-5)
    path = tmp_path / f"t{plan.ending}"
    written = baked.save(path)
    for piece in plan.pieces:
        for channel in plan.channels:
            table = ecfit.read_layout(
                path,
                name,
                counts={n.name: 4 for n in plan.axes},
                piece=piece.name or None,
                channel=channel.name or None,
            )
            found = ecfit.audit(table)
            assert found.ok, str(found)
            assert found.drift.largest <= written.bound + 2e-5
