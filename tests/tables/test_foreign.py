"""Tables from files: what others write is read, what nobody can mean is one error, nothing is executed."""

import os
import random
import re

import numpy as np
import OpenEXR
import pytest

import ecfit
from ecfit import Axis, EcfitError, Table, read_table
from ecfit.tables import Given

AXES = {"r": 3, "mu": Axis.spaced("mu", 4, spacing="texel-centre")}
VALUES = np.array([[0.97, 0.98, 0.99, 1.0], [0.8, 0.85, 0.9, 0.95], [0.3, 0.4, 0.5, 0.6]])
UNKNOWN = {"model": "unknown"}
F4 = VALUES.astype(np.float32)


def npy(path, array):
    np.save(path, array)
    return path


def exr(path, *channels, kind=OpenEXR.scanlineimage):
    """An image of one part for each dictionary of channels."""
    parts = [OpenEXR.Part({"type": kind}, dict(c), f"part{i}") for i, c in enumerate(channels)]
    OpenEXR.File(parts).write(str(path))
    return path


def text(path, content):
    path.write_text(content)
    return path


def matrix(array, separator=", "):
    return "\n".join(separator.join(repr(float(x)) for x in row) for row in array) + "\n"


def refused(words, *arguments, **settings):
    with pytest.raises(EcfitError) as caught:
        read_table(*arguments, **settings)
    message = str(caught.value)
    assert re.search(words, message), message
    assert "\n" not in message


# NPY


@pytest.mark.parametrize("array", [VALUES, VALUES.ravel(), np.asfortranarray(VALUES), VALUES[None]])
def test_npy_is_read_in_the_order_of_the_axes(tmp_path, array):
    table = read_table(npy(tmp_path / "t.npy", array), AXES, UNKNOWN)
    np.testing.assert_array_equal(table.values, VALUES)
    assert table.provenance["source"] == "t.npy"


def test_npy_of_16_bits_of_one_minus_e_with_roughness_fastest(tmp_path):
    stored = np.round((1.0 - VALUES.T) * 65535).astype(np.uint16)
    path = npy(tmp_path / "t.npy", stored.ravel())
    table = read_table(path, AXES, UNKNOWN, "1-E", ["mu", "r"], scale=65535)
    np.testing.assert_allclose(table.values, VALUES, atol=0.5 / 65535)


@pytest.mark.parametrize("channel", ["1", "G"])
def test_npy_has_channels_in_its_last_dimension(tmp_path, channel):
    path = npy(tmp_path / "t.npy", np.stack([0 * VALUES, VALUES], axis=-1))
    np.testing.assert_array_equal(read_table(path, AXES, UNKNOWN, channel=channel).values, VALUES)
    refused("axes need 12 in all.*which channel", path, AXES, UNKNOWN)
    for wrong in ("2", "B", "", "RG", "-1", "9" * 30):
        refused("no channel.*expected 0 to 1", path, AXES, UNKNOWN, channel=wrong)


class Bomb:
    """Fails the test where it is unpickled."""

    def __reduce__(self):
        return (pytest.fail, ("a pickle was executed",))


def test_a_pickle_is_never_executed(tmp_path):
    path = tmp_path / "t.npy"
    np.save(path, np.array([[Bomb()] * 4] * 3, dtype=object), allow_pickle=True)
    refused("it holds Python objects", path, AXES, UNKNOWN)
    import pickle

    path.write_bytes(pickle.dumps(Bomb()))
    refused("damaged or no .npy file", path, AXES, UNKNOWN)


@pytest.mark.parametrize(
    "array",
    [VALUES + 0j, VALUES > 0.5, VALUES.astype("U5"), np.zeros((3, 4), "M8[s]"), np.zeros(12, "f8,i4")],
)
def test_npy_of_other_types_is_refused(tmp_path, array):
    refused("expected real numbers", npy(tmp_path / "t.npy", array), AXES, UNKNOWN)


def test_npy_that_claims_to_be_huge_is_refused_at_once(tmp_path):
    path = tmp_path / "t.npy"
    with path.open("wb") as file:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**7, 10**7)}
        np.lib.format.write_array_header_1_0(file, header)
    refused("damaged", path, AXES, UNKNOWN)
    npy(path, np.zeros(10**6))
    refused("holds 1000000 numbers, the axes need 12", path, AXES, UNKNOWN)


def test_a_transposed_file_is_told_from_its_shape(tmp_path):
    path = npy(tmp_path / "t.npy", VALUES.T)
    refused(r"4 x 3 numbers.*order = \['mu', 'r'\] would fit", path, AXES, UNKNOWN)


# EXR


@pytest.mark.parametrize("kind", [OpenEXR.scanlineimage, OpenEXR.tiledimage])
@pytest.mark.parametrize("name", ["R", "Y", "albedo"])
def test_exr_of_one_channel_is_read(tmp_path, name, kind):
    settings = {"tiles": OpenEXR.TileDescription()} if kind == OpenEXR.tiledimage else {}
    OpenEXR.File({"type": kind, **settings}, {name: F4.copy()}).write(str(tmp_path / "t.exr"))
    table = read_table(tmp_path / "t.exr", AXES, UNKNOWN)
    np.testing.assert_array_equal(table.values, F4.astype(np.float64))


def test_exr_of_half_precision_and_two_channels(tmp_path):
    half = VALUES.astype(np.float16)
    path = exr(tmp_path / "t.exr", {"R": half.copy(), "G": (1 - half).copy()})
    np.testing.assert_array_equal(read_table(path, AXES, UNKNOWN).values, half.astype(np.float64))
    other = read_table(path, AXES, UNKNOWN, stored="1-E", channel="G")
    np.testing.assert_allclose(other.values, VALUES, atol=1e-3)
    refused("no channel 'B': expected one of G, R", path, AXES, UNKNOWN, channel="B")


def test_exr_without_a_usual_channel_asks(tmp_path):
    path = exr(tmp_path / "t.exr", {"a": F4.copy(), "b": F4.copy()})
    refused("which channel.*a, b", path, AXES, UNKNOWN)


def test_exr_of_three_dimensions_in_every_arrangement(tmp_path):
    axes = {"r": 3, "mu": 4, "F0": 2}
    cube = np.random.default_rng(1).random((2, 3, 4)).astype(np.float32)  # [F0, r, mu]
    below = exr(tmp_path / "below.exr", {"R": cube.reshape(6, 4).copy()})
    beside = exr(tmp_path / "beside.exr", {"R": np.concatenate(list(cube), axis=1)})
    parts = exr(tmp_path / "parts.exr", *({"R": plane.copy()} for plane in cube))
    expected = cube.transpose(1, 2, 0).astype(np.float64)
    for path, order in (
        (below, ["F0", "r", "mu"]),
        (beside, ["r", "F0", "mu"]),
        (parts, ["F0", "r", "mu"]),
    ):
        np.testing.assert_array_equal(read_table(path, axes, UNKNOWN, order=order).values, expected)


def test_exr_upside_down(tmp_path):
    path = exr(tmp_path / "t.exr", {"R": F4[::-1].copy()})
    np.testing.assert_array_equal(read_table(path, AXES, UNKNOWN, order=["-r", "mu"]).values, F4)


def test_exr_of_another_size_is_refused_before_its_pixels_are_read(tmp_path, monkeypatch):
    path = exr(tmp_path / "t.exr", {"R": np.zeros((5, 7), np.float32)})
    opened = []
    original = OpenEXR.File

    def watched(*args, **settings):
        opened.append(settings.get("header_only"))
        return original(*args, **settings)

    monkeypatch.setattr(OpenEXR, "File", watched)
    refused("5 x 7 pixels.*axes need 12", path, AXES, UNKNOWN)
    assert opened == [True]


def test_exr_with_parts_of_several_sizes_or_deep_pixels_is_refused(tmp_path):
    window = (np.array([0, 0], np.int32), np.array([3, 1], np.int32))
    parts = [
        OpenEXR.Part({"type": OpenEXR.scanlineimage, "displayWindow": window}, {"R": rows.copy()}, f"{i}")
        for i, rows in enumerate((F4[:1], F4[1:]))
    ]
    OpenEXR.File(parts).write(str(tmp_path / "s.exr"))
    refused("1 x 4, 2 x 4 pixels", tmp_path / "s.exr", AXES, UNKNOWN)
    deep = np.empty((3, 4), dtype=object)
    for i in np.ndindex(3, 4):
        deep[i] = np.array([1.0, 2.0], np.float32)
    header = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}
    OpenEXR.File(header, {"R": deep}).write(str(tmp_path / "d.exr"))
    refused("deep", tmp_path / "d.exr", AXES, UNKNOWN)


# CSV


@pytest.mark.parametrize(
    "content",
    [
        matrix(VALUES),
        matrix(VALUES, ";"),
        matrix(VALUES, "\t"),
        matrix(VALUES, "   "),
        "# E of r and mu\n\n" + matrix(VALUES).replace("\n", ",  # a row\n"),
        "\ufeff" + matrix(VALUES).replace("\n", "\r\n"),
        matrix(VALUES.reshape(12, 1)),
        matrix(VALUES.reshape(1, 12)),
        matrix(VALUES.reshape(6, 2)),  # a list with wrapped lines
        matrix(VALUES.ravel()[None, :5]) + matrix(VALUES.ravel()[None, 5:10]) + matrix([VALUES[2, 2:]]),
    ],
)
def test_csv_without_a_header_is_a_matrix_or_a_list(tmp_path, content):
    table = read_table(text(tmp_path / "t.csv", content), AXES, UNKNOWN)
    np.testing.assert_array_equal(table.values, VALUES)


def test_csv_with_roughness_fastest(tmp_path):
    path = text(tmp_path / "t.csv", matrix(VALUES.T))
    np.testing.assert_array_equal(read_table(path, AXES, UNKNOWN, order=["mu", "r"]).values, VALUES)


def long(digits=17, column="value", extra=""):
    mu = AXES["mu"].nodes
    r = (0.0, 0.5, 1.0)
    lines = [
        f"{r[i]:.{digits}g},{float(value)!r}{extra},{mu[j]:.{digits}g}"
        for (i, j), value in np.ndenumerate(VALUES)
    ]
    random.Random(3).shuffle(lines)
    return f"r,{column}{',note' if extra else ''},mu\n" + "\n".join(lines)


@pytest.mark.parametrize(
    ("content", "channel"),
    [(long(), None), (long(3), None), (long(column="A"), "A"), (long(extra=",text"), None)],
)
def test_csv_with_a_header_has_a_line_an_entry_in_any_order(tmp_path, content, channel):
    table = read_table(text(tmp_path / "t.csv", content), AXES, UNKNOWN, channel=channel)
    np.testing.assert_array_equal(table.values, VALUES)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "is empty"),
        ("# only\n", "is empty"),
        (matrix(VALUES[:2]), "2 x 4 numbers, expected r = 3 x mu = 4"),
        (matrix(VALUES.T), r"order = \['mu', 'r'\] would fit"),
        (matrix(VALUES).replace("0.85", "x"), "t.csv:2: 'x' is not a number"),
        (matrix(VALUES).replace("0.85", "0.8.5"), "t.csv:2: '0.8.5' is not a number"),
        (matrix(VALUES).replace("0.85", ""), "t.csv:2: '' is not a number"),
        (matrix(VALUES).replace("0.85", "nan"), "1 of 12 values are NaN.*r = 0.5, mu = 0.375"),
        (matrix(VALUES).replace("0.85", "1e999"), "NaN or infinite"),
        (matrix(VALUES).replace("0.85, ", ""), "t.csv:2: not as many numbers.*11 in all, expected 12"),
        (long().replace("r,", "rough,"), "column 'r' is not in the header"),
        (long().replace("value", "vlaue"), "did you mean 'vlaue'"),
        (long().replace("r,", "mu,"), "column 'r' is not"),
        (long() + "\n0,0.5,0.125", "2 values at r = 0, mu = 0.125"),
        (long().rsplit("\n", 1)[0], "0 values at r = "),
        (long() + "\n0,0.5,0.2", "t.csv:14: mu = 0.2 is no node.*nearest is 0.125"),
        (long() + "\n0,0.5,nan", "mu = nan is no node"),
        (long() + "\n0,0.5", "t.csv:14: 2 cells, the header has 3"),
        ("r,value,mu\n", "0 values at r = 0"),
        ("import os\nos.abort()", "column 'r' is not"),
    ],
)
def test_csv_faults_are_told_with_their_line(tmp_path, content, words):
    refused(words, text(tmp_path / "t.csv", content), AXES, UNKNOWN)


def test_csv_settings_that_mean_nothing_are_refused(tmp_path):
    refused("leave order out", text(tmp_path / "t.csv", long()), AXES, UNKNOWN, order=["r", "mu"])
    refused("leave channel out", text(tmp_path / "t.csv", matrix(VALUES)), AXES, UNKNOWN, channel="R")
    refused("each axis once", text(tmp_path / "t.csv", matrix(VALUES)), AXES, UNKNOWN, order=["r", "nu"])


def test_csv_that_is_much_too_large_is_not_read(tmp_path):
    path = tmp_path / "t.csv"
    with path.open("wb") as file:
        file.truncate(1 << 33)
    refused("8589934592 bytes, more than 12 entries take", path, AXES, UNKNOWN)


# Any file


@pytest.mark.parametrize("kind", ["npy", "csv", "exr"])
def test_files_that_cannot_be_read_are_told(tmp_path, kind):
    refused("no such file", tmp_path / f"none.{kind}", AXES, UNKNOWN)
    (tmp_path / f"folder.{kind}").mkdir()
    refused("is not a file", tmp_path / f"folder.{kind}", AXES, UNKNOWN)
    refused("no such file|cannot read", f"a\0b.{kind}", AXES, UNKNOWN)
    os.mkfifo(tmp_path / f"pipe.{kind}")
    refused("is not a file", tmp_path / f"pipe.{kind}", AXES, UNKNOWN)
    (tmp_path / f"binary.{kind}").write_bytes(b"\x00\xff\x80" * 40)
    refused("damaged|not a text file", tmp_path / f"binary.{kind}", AXES, UNKNOWN)


def test_other_kinds_of_files_are_refused(tmp_path):
    refused(r"unknown kind of table file 't.png': expected one of .*\*.csv, \*.exr, .*\*.npy",
            npy(tmp_path / "t.npy", VALUES).rename(tmp_path / "t.png"), AXES, UNKNOWN)  # fmt: skip


def test_axes_of_a_file_need_counts(tmp_path):
    path = npy(tmp_path / "t.npy", VALUES)
    refused("how many nodes", path, {"r": "uniform", "mu": 4}, UNKNOWN)
    refused("'ior' has no range", path, {"ior": 3, "mu": 4}, UNKNOWN)


@pytest.mark.parametrize("kind", ["npy", "exr", "csv"])
def test_random_damage_is_an_error_or_a_table(tmp_path, kind):
    path = tmp_path / f"t.{kind}"
    if kind == "npy":
        npy(path, VALUES)
    elif kind == "exr":
        exr(path, {"R": F4.copy(), "G": F4.copy()})
    else:
        text(path, long())
    good, rng = path.read_bytes(), random.Random(5)
    for _ in range(400):
        data = bytearray(good)
        for _ in range(rng.choice((1, 1, 3))):
            data[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(data[: rng.choice((len(data), len(data), rng.randrange(len(data))))])
        try:
            table = read_table(path, AXES, UNKNOWN)
        except EcfitError:
            continue
        assert np.isfinite(table.values).all()


def test_a_given_table_takes_the_place_of_a_request():
    table = Table.from_array(VALUES, AXES, UNKNOWN)
    given, done = Given(table), []
    assert given.grid.shape == (3, 4)
    assert given.key == table.provenance["key"]
    assert given.compute(done.append) is table
    assert done == [12]


def test_a_table_of_ours_comes_back_from_every_format(tmp_path):
    """What somebody exports of our numbers and hands in again gives the same fit."""
    ours = ecfit.tabulate("conductor", {"r": 6, "mu": 8}, tolerance=1e-4)
    single = ours.values.astype(np.float32)
    axes = {axis.name: axis for axis in ours.axes}
    files = (
        npy(tmp_path / "t.npy", single),
        exr(tmp_path / "t.exr", {"Y": single.copy()}),
        text(tmp_path / "t.csv", matrix(single)),
    )
    fits = [ecfit.fit(read_table(f, axes, ours.contract), ecfit.Rational(1)) for f in files]
    for fit in fits:
        np.testing.assert_array_equal(fit.coefficients, fits[0].coefficients)
    np.testing.assert_allclose(fits[0].mae, ecfit.fit(ours, ecfit.Rational(1)).mae, rtol=1e-3)
