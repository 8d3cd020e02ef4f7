"""Layouts: written, read back by name and by what the file says, within the stated rounding."""

import json
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import ecfit
from ecfit import Axis, EcfitError, Table, read_layout, write_table
from ecfit.contract import Contract
from ecfit.tables import LAYOUTS
from ecfit.tables.consumers import Nodes, layout
from ecfit.tables.numbers import NUMBERS
from ecfit.tables.said import MARK, axis_from_dict, axis_to_dict

NAMED = [name for name, plan in LAYOUTS.items() if plan.axes]


def small(name):
    """A layout with few nodes, as many along no two axes."""
    plan = layout(name)
    return replace(plan, axes=tuple(replace(n, count=4 + i) for i, n in enumerate(plan.axes)))


def synthetic(plan):
    """A table for every slot of a layout: smooth, in [0, 1], another for each slot."""
    tables = []
    for i, piece in enumerate(plan.pieces):
        for j, channel in enumerate(plan.channels):
            axes = {n.name: n.axis() for n in plan.axes}
            mesh = np.meshgrid(*(a.nodes for a in axes.values()), indexing="ij")
            values = 0.1 + 0.3 * i + 0.05 * j
            for k, x in enumerate(mesh):
                values = values + 0.5 * np.cos((k + 1.0) * x / (1.0 + x)) / len(mesh) / (k + 1.0)
            quantity = channel.quantity or "directional-albedo"
            contract = Contract("unknown", dict(piece.options), quantity=quantity)
            tables.append(Table.from_array(values, axes, contract, source=f"slot {i}.{j}"))
    return tables


def endings(plan):
    several = len(plan.channels) * len(plan.pieces) > 1
    out = [".h", ".npy", ".bin"]
    out += [] if plan.number in ("uint16", "float64") else [".exr"]
    return out + ([] if several else [".csv"])


@pytest.mark.parametrize("name", NAMED)
def test_a_layout_is_read_back_within_its_rounding(tmp_path, name):
    plan = small(name)
    tables = synthetic(plan)
    for ending in endings(plan):
        path = tmp_path / f"t{ending}"
        written = write_table(tables, path, plan)
        assert written.rounding <= written.bound
        slots = [(p, c) for p in plan.pieces for c in plan.channels]
        for (piece, channel), table in zip(slots, tables, strict=True):
            which = {"piece": piece.name or None, "channel": channel.name or None}
            back = read_layout(path, name, counts={n.name: n.count for n in plan.axes}, **which)
            assert back.names == tuple(n.name for n in plan.axes)
            assert np.abs(back.values - table.values).max() <= written.bound
            for ours, theirs in zip(table.axes, back.axes, strict=True):
                np.testing.assert_array_equal(ours.nodes, theirs.nodes)
                np.testing.assert_array_equal(ours.nominal, theirs.nominal)
            if ending in (".h", ".csv", ".exr"):
                told = read_layout(path, **which)
                np.testing.assert_array_equal(told.values, back.values)
                assert told.contract == table.contract
                for ours, theirs in zip(table.axes, told.axes, strict=True):
                    np.testing.assert_array_equal(ours.nodes, theirs.nodes)


@pytest.mark.parametrize("number", sorted(NUMBERS))
@pytest.mark.parametrize("stored", ["E", "1-E"])
def test_rounding_is_what_is_stated(tmp_path, number, stored, make_table, unit_axis):
    table = make_table(lambda r, mu: 0.02 + 0.9 * np.sin(r + mu) ** 2, unit_axis("r", 5), unit_axis("mu", 7))
    written = write_table(table, tmp_path / "t.h", number=number, stored=stored, order=["-mu", "r"])
    back = read_layout(tmp_path / "t.h")
    assert back.names == ("r", "mu")
    moved = np.abs(back.values - table.values).max()
    # 1 - (1 - E) itself rounds in double precision.
    assert moved <= written.bound + 2e-16
    assert written.rounding == pytest.approx(moved, rel=1e-6, abs=2e-16)
    assert number == "float64" or written.bound > 0.0
    if number == "uint16":
        assert written.bound == 0.5 / 65535


def test_the_order_in_the_file_is_the_layout_s(tmp_path):
    """By hand, not by our reader: roughness fastest in Cycles, 16 bits of 1 - E, interleaved halves."""
    plan = layout("cycles")
    (table,) = synthetic(plan)
    write_table(table, tmp_path / "t.bin", "cycles")
    flat = np.fromfile(tmp_path / "t.bin", "<f4")
    mu, r = (a.nodes for a in table.axes)
    assert (table.names, mu[0], r[-1]) == (("mu", "r"), 1e-4, 1.0)
    np.testing.assert_allclose(flat[:3], table.values[0, :3], atol=1e-7)
    np.testing.assert_allclose(flat[32 * 5 + 7], table.values[5, 7], atol=1e-7)

    (table,) = synthetic(layout("openpbr-bsdf"))
    write_table(table, tmp_path / "t.bin", "openpbr-bsdf")
    words = np.fromfile(tmp_path / "t.bin", "<u2")
    assert words[32 * 5 + 7] == round((1.0 - table.values[5, 7]) * 65535)

    a, b = synthetic(layout("three"))
    write_table([a, b], tmp_path / "t.bin", "three")
    halves = np.fromfile(tmp_path / "t.bin", "<f2")
    np.testing.assert_array_equal(halves[:4], np.float16([a.values[0, 0], b.values[0, 0], a.values[0, 1],
                                                         b.values[0, 1]]))  # fmt: skip


def test_pieces_follow_each_other_and_may_run_backwards(tmp_path):
    plan = layout("openpbr-bsdf-dielectric")
    leaving, entering = synthetic(plan)
    write_table([leaving, entering], tmp_path / "t.npy", plan)
    stored = np.load(tmp_path / "t.npy")
    assert stored.shape == (32, 32, 32)
    # Index 0 is 1 / 2.5, index 15 is 1 from below, 16 is 1 from above, 31 is 2.5.
    index = [(0, leaving, -1), (15, leaving, 0), (16, entering, 0), (31, entering, -1)]
    for i, table, ior in index:
        expected = np.rint((1.0 - table.values[ior]) * 65535)
        np.testing.assert_array_equal(stored[i], expected)


def test_three_dimensions_in_exr_are_an_atlas_or_parts(tmp_path):
    import OpenEXR

    plan = layout("cycles-glass")
    (table,) = synthetic(plan)
    for parts, shape in ((False, (256, 16)), (True, (16, 16))):
        write_table(table, tmp_path / "t.exr", plan, parts=parts)
        np.testing.assert_allclose(read_layout(tmp_path / "t.exr").values, table.values, atol=1e-7)
        with OpenEXR.File(str(tmp_path / "t.exr"), separate_channels=True) as file:
            assert len(file.parts) == (16 if parts else 1)
            assert file.parts[0].channels["Y"].pixels.shape == shape
            said = json.loads(file.parts[0].header["ecfitTable"])
            assert said["contracts"][0]["model"] == "unknown"


def test_a_table_in_another_view_is_the_layout_s(tmp_path):
    r = Axis.spaced("r", 4)
    axes = {"alpha": Axis.given("alpha", r.nodes**2), "mu": 3}
    table = Table.from_array(np.linspace(0.1, 0.9, 12).reshape(4, 3), axes, {"model": "unknown"})
    plan = layout("yocto")
    write_table(table, tmp_path / "t.csv", plan)
    back = read_layout(tmp_path / "t.csv", plan, counts={"r": 4, "mu": 3})
    np.testing.assert_array_equal(back.values, table.values)
    uneven = {"r": [0.0, 0.2, 0.5, 1.0], "mu": 3}
    other = Table.from_array(table.values, uneven, {"model": "unknown"})
    with pytest.raises(EcfitError, match="other nodes of r"):
        write_table(other, tmp_path / "t.csv", plan)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["cycles", "openpbr-bsdf", "three", "osl-dielectric-front"])
def test_c_source_compiles_and_holds_the_numbers(tmp_path, name):
    plan = small(name)
    tables = synthetic(plan)
    write_table(tables, tmp_path / "t.h", plan, name="table_E")
    write_table(tables, tmp_path / "t.bin", plan)
    code = '#include <stdio.h>\n#include "t.h"\nint main(void) { return fwrite(table_E, 1, sizeof table_E, '
    (tmp_path / "t.c").write_text(code + "stdout) != sizeof table_E; }\n")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]
    subprocess.run(["cc", *flags, "t.c", "-o", "t"], cwd=tmp_path, check=True)
    printed = subprocess.run(["./t"], cwd=tmp_path, check=True, capture_output=True).stdout
    assert printed == (tmp_path / "t.bin").read_bytes()


SOURCES = {
    "several arrays": "float a[2] = {1, 2}; static const float b[2][2] = {{0.5f, .25F}, {1e-1f, 1.f}};",
    "comments": "/* {9} */ const double b[4] = { // 7, 8\n0.5, 0.25, 0.1, 1.0, };",
    "javascript": "const b = new Float32Array( [\n0.5, 0.25, 0.1, 1\n] );",
    "a list": "0.5, 0.25,\n0.1, 1.0",
}


@pytest.mark.parametrize("case", SOURCES)
def test_arrays_in_source_are_read(tmp_path, case):
    path = tmp_path / ("t.js" if case == "javascript" else "t.h")
    path.write_text(SOURCES[case])
    channel = "b" if case == "several arrays" else None
    table = ecfit.read_table(path, {"r": 2, "mu": 2}, {"model": "unknown"}, channel=channel)
    np.testing.assert_array_equal(table.values, [[0.5, 0.25], [0.1, 1.0]])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("float a[4] = {1, 2, 3, f(4)};", "other things than numbers"),
        ("float a[4] = {1, 2, 3, 4", "ends within"),
        ("float a[3] = {1, 2, 3};", "holds 3 numbers"),
        ("int main() { return system(0); }", "no array"),
        ("", "no array"),
        ("float a[1] = {1}; float b[1] = {2};", "several arrays.*a, b"),
    ],
)
def test_source_that_is_no_table_is_refused(tmp_path, text, words):
    (tmp_path / "t.h").write_text(text)
    with pytest.raises(EcfitError, match=words):
        ecfit.read_table(tmp_path / "t.h", {"r": 2, "mu": 2}, {"model": "unknown"})


@pytest.mark.parametrize("number", ["65536", "1e300", "18446744073709551616"])
def test_bits_of_halves_end_at_16(tmp_path, number):
    (tmp_path / "t.h").write_text(f"unsigned short a[4] = {{0, 1, 65535, {number}}};")
    with pytest.raises(EcfitError, match="among the bits of halves"):
        ecfit.read_table(tmp_path / "t.h", {"r": 2, "mu": 2}, {"model": "unknown"}, number="float16")


def test_raw_numbers_need_their_type(tmp_path):
    path = tmp_path / "t.bin"
    np.arange(4, dtype="<u2").tofile(path)
    axes, unknown = {"r": 2, "mu": 2}, {"model": "unknown"}
    with pytest.raises(EcfitError, match="does not say what its numbers are"):
        ecfit.read_table(path, axes, unknown)
    with pytest.raises(EcfitError, match="holds 1 numbers, the axes need 4"):
        ecfit.read_table(path, axes, unknown, number="float64")
    table = ecfit.read_table(path, axes, unknown, number="uint16", scale=3)
    np.testing.assert_array_equal(table.values.ravel(), np.arange(4) / 3)


def test_what_cannot_be_written_is_refused(tmp_path, make_table, unit_axis):
    table = make_table(lambda r, mu: 2.0 * r + mu, unit_axis("r", 3), unit_axis("mu", 3))

    def refused(words, *arguments, **settings):
        with pytest.raises(EcfitError, match=words) as caught:
            write_table(*arguments, **settings)
        assert "\n" not in str(caught.value)

    refused("uint16 holds 0 to 1", table, tmp_path / "t.bin", number="uint16")
    refused("unknown layout 'cicles'.*did you mean 'cycles'", table, tmp_path / "t.h", "cicles")
    refused("unknown type of number", table, tmp_path / "t.h", number="float8")
    refused("kind of table file", table, tmp_path / "t.txt")
    refused("OpenEXR has no float64", table, tmp_path / "t.exr")
    refused("takes 2 table", table, tmp_path / "t.h", "three")
    refused("no name of an array", table, tmp_path / "t.h", name="a b")
    refused(
        "only arrays of C source have a name, not .csv: leave out name", table, tmp_path / "t.csv", name="a"
    )
    for file in ("t.exr", "t.npy"):
        refused("leave parts out", table, tmp_path / file, number="float32", parts=True)
    refused("order must name each axis once", table, tmp_path / "t.h", order=["r"])
    refused("other nodes of", table, tmp_path / "t.h", "enterprise-pbr")
    a, b = synthetic(layout("three"))
    refused("channel R holds schlick-a", [b, a], tmp_path / "t.h", "three")
    assert not list(tmp_path.iterdir())


def test_damaged_words_of_a_file_are_told(tmp_path):
    table = Table.from_array(np.full((3, 3), 0.5), {"r": 3, "mu": 3}, {"model": "unknown"})
    path = tmp_path / "t.h"
    write_table(table, path)
    text = path.read_text()
    for damage in ('{"layout": 3', "[1]", '{"axes": [], "channels": [""], "pieces": []}'):
        path.write_text("\n".join(f"{MARK} {damage}" if MARK in row else row for row in text.splitlines()))
        with pytest.raises(EcfitError, match="damaged"):
            read_layout(path)
    path.write_text(text)
    with pytest.raises(EcfitError, match="no piece 'front', it is one table: leave piece out"):
        read_layout(path, piece="front")
    with pytest.raises(EcfitError, match="no piece 'front', it is one table: leave piece out"):
        read_layout(path, "yocto", piece="front")
    with pytest.raises(EcfitError, match="no channel 'R', it has one: leave channel out"):
        read_layout(path, channel="R")
    for damage in ('"errors": [-1.0]', '"errors": ["x"]', '"errors": []', '"errors": 1'):
        path.write_text(text.replace('"errors": [null]', damage))
        with pytest.raises(EcfitError, match="errors must be|damaged"):
            read_layout(path)
    path.write_text(text.replace('"errors": [null], ', ""))  # as files were written before they said it
    assert not read_layout(path).estimated
    path.write_text("float a[9] = {1,2,3,4,5,6,7,8,9};")
    with pytest.raises(EcfitError, match="does not say what it is"):
        read_layout(path)


@pytest.mark.parametrize(
    "axis",
    [
        Axis.spaced("mu", 7, spacing="texel-centre"),
        Axis.spaced("F0", 5, through="fourth-power"),
        Axis.spaced("r", 6, 0.035, 1.0, "clamped"),
        Axis.given("ior", [1.0, 1.3, 2.5]),
        Nodes("F0", 16, power=4, clip=(1e-4, 0.99)).axis(),
    ],
)
def test_axes_are_said_exactly(axis):
    back = axis_from_dict(json.loads(json.dumps(axis_to_dict(axis))))
    np.testing.assert_array_equal(back.nodes, axis.nodes)
    np.testing.assert_array_equal(back.nominal, axis.nominal)
    assert (back.name, back.low, back.high, back.clamped) == (axis.name, axis.low, axis.high, axis.clamped)


def test_every_layout_names_its_source():
    for plan in LAYOUTS.values():
        text = "\n".join(plan.describe())
        assert plan.source in text
        assert plan.name in text
        assert plan.number in NUMBERS
        assert plan.stored in ("E", "1-E")
