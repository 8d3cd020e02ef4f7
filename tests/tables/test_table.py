"""`Table` files: bit-exact round trips, and one kind of error for anything else."""

import io
import json
import pickle
import random
import zipfile
from typing import Any

import numpy as np
import pytest

import ecfit
from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.quadrature import Status
from ecfit.tables import Table


@pytest.fixture(scope="module")
def table() -> Table:
    """3 x 4 entries with every kind of axis, number and status."""
    axes = (Axis.spaced("r", 3, 0.035, 1.0, "clamped"), Axis.spaced("mu", 4, 0.1, 0.9, "gauss", "square"))
    values = np.array([[0.1, 1 / 3, np.nan, 1.0], [5e-324, -0.0, 1e300, 0.25], [np.pi, np.e, 2.0, np.inf]])
    errors = np.where(np.isfinite(values), 1e-9 / 3, np.inf)
    status = np.where(np.isfinite(values), 0, 2)
    status[0, 0] = 1
    contract = Contract("conductor", {"ndf": "ggx"}, {"F0": 1 / 3}, sampling="clamped")
    return Table(values, errors, status.astype(np.int8), axes, contract, 1e-7, {"key": "abc", "ecfit": "1"})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tables")


@pytest.fixture(scope="module")
def saved(table, folder) -> bytes:
    table.save(folder / "saved.npz")
    return (folder / "saved.npz").read_bytes()


def load(data: bytes, folder) -> Table:
    path = folder / "damaged.npz"
    path.write_bytes(data)
    return Table.load(path)


def rewritten(saved: bytes, **changes: Any) -> bytes:
    """The same file with other arrays (None: left out)."""
    with np.load(io.BytesIO(saved)) as file:
        arrays = {name: file[name] for name in file.files}
    arrays = {k: v for k, v in {**arrays, **changes}.items() if v is not None}
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def with_header(saved: bytes, change) -> bytes:
    """The same file with another header."""
    with np.load(io.BytesIO(saved)) as file:
        header = json.loads(str(file["header"]))
    change(header)
    return rewritten(saved, header=np.array(json.dumps(header)))


def test_a_table_survives_its_file_bit_by_bit(table, saved, folder):
    again = load(saved, folder)
    for name in ("values", "errors", "status"):
        old, new = getattr(table, name), getattr(again, name)
        assert (old.dtype, old.tobytes()) == (new.dtype, new.tobytes())
    for old, new in zip(table.axes, again.axes, strict=True):
        assert old.nodes.tobytes() == new.nodes.tobytes()
        assert old.nominal.tobytes() == new.nominal.tobytes()
        assert (old.name, old.spacing, old.through, old.low, old.high) == (
            new.name,
            new.spacing,
            new.through,
            new.low,
            new.high,
        )
    assert again.contract == table.contract
    assert again.tolerance == table.tolerance
    assert again.provenance == table.provenance


def test_saving_again_writes_the_same_bytes_but_for_dates(table, saved, folder):
    table.save(folder / "again.npz")
    with zipfile.ZipFile(io.BytesIO(saved)) as a, zipfile.ZipFile(folder / "again.npz") as b:
        assert {n: a.read(n) for n in a.namelist()} == {n: b.read(n) for n in b.namelist()}


def test_the_file_needs_no_pickle(saved):
    with np.load(io.BytesIO(saved), allow_pickle=False) as file:
        assert all(file[name].dtype.kind in "fiuU" for name in file.files)


def test_a_failed_write_leaves_the_old_file(table, folder, monkeypatch):
    path = folder / "kept.npz"
    table.save(path)
    before = path.read_bytes()

    def killed(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "savez", killed)
    with pytest.raises(KeyboardInterrupt):
        table.save(path)
    assert path.read_bytes() == before
    assert not [p for p in folder.iterdir() if p.name.endswith(".part")]


def test_a_missing_file_is_named(folder):
    with pytest.raises(EcfitError, match=r"no such table.*none\.npz"):
        Table.load(folder / "none.npz")


def test_a_folder_is_no_table(folder):
    with pytest.raises(EcfitError, match="cannot read"):
        Table.load(folder)


@pytest.mark.parametrize("keep", [0, 1, 30, 400, 0.5, 0.9, -1])
def test_a_truncated_file_is_damaged(saved, folder, keep):
    count = int(keep * len(saved)) if isinstance(keep, float) else keep
    with pytest.raises(EcfitError, match="damaged"):
        load(saved[:count], folder)


def npy(array) -> bytes:
    out = io.BytesIO()
    np.save(out, array, allow_pickle=True)
    return out.getvalue()


class Bomb:
    """Fails the test where it is unpickled."""

    def __reduce__(self):
        return (pytest.fail, ("a pickle was executed",))


@pytest.mark.parametrize(
    "data",
    [
        b"garbage",
        b"PK\x03\x04" + b"\0" * 100,
        pickle.dumps(Bomb()),
        npy(np.zeros(3)),
        npy(np.array([Bomb()], dtype=object)),
    ],
    ids=["text", "zip header", "pickle", "one array", "array of objects"],
)
def test_other_files_are_no_tables(data, folder):
    with pytest.raises(EcfitError, match="damaged"):
        load(data, folder)


def test_an_array_of_objects_inside_is_not_unpickled(saved, folder):
    with pytest.raises(EcfitError, match="damaged"):
        load(rewritten(saved, values=np.array([Bomb()], dtype=object)), folder)


@pytest.mark.parametrize(
    "changes",
    [
        {"values": None},
        {"header": None},
        {"nodes_0": None},
        {"header": np.array("[1]")},
        {"header": np.array("not JSON")},
        {"header": np.array("[" * 100_000)},
        {"header": np.array(3)},
        {"values": np.zeros((2, 2))},
        {"values": np.full((3, 4), "a")},
        {"errors": np.zeros(12)},
        {"status": np.full((3, 4), "a")},
        {"nodes_0": np.array([3.0, 2.0, 1.0])},
        {"nominal_0": np.array([0.0, 0.0, 1.0])},
        {"nodes_0": np.array([0.1, np.nan, 1.0])},
    ],
    ids=str,
)
def test_missing_and_wrong_arrays_are_refused(saved, folder, changes):
    with pytest.raises(EcfitError):
        load(rewritten(saved, **changes), folder)


@pytest.mark.parametrize(
    "change",
    [
        lambda h: h.update(format="other"),
        lambda h: h.update(axes=5),
        lambda h: h.update(axes=[]),
        lambda h: h.update(contract={"model": "x", "quantity": "other"}),
        lambda h: h.update(contract={"model": "x", "surprise": 1}),
        lambda h: h.update(contract=5),
        lambda h: h.update(tolerance="x"),
        lambda h: h.update(tolerance=10**400),
        lambda h: h.update(provenance=5),
        lambda h: h["axes"][0].update(name="mu"),
        lambda h: h["axes"][0].update(name=""),
        lambda h: h["axes"][0].update(spacing="other"),
        lambda h: h["axes"][0].update(low="x"),
        lambda h: h["axes"][0].update(low=10**400),
        lambda h: h.pop("contract"),
    ],
)
def test_wrong_headers_are_refused(saved, folder, change):
    with pytest.raises(EcfitError):
        load(with_header(saved, change), folder)


def test_random_damage_is_an_error_or_harmless(saved, folder):
    """Never another exception: zipfile alone has a dozen for the fields of its headers."""
    rng = random.Random(7)
    headers = saved.index(b"PK\x01\x02")  # the central directory, where a flipped bit means most
    harmless = 0
    for attempt in range(1500):
        data = bytearray(saved)
        for _ in range(rng.choice((1, 1, 3))):
            data[rng.randrange(headers if attempt % 2 else 0, len(data))] = rng.randrange(256)
        try:
            load(bytes(data), folder)
            harmless += 1
        except EcfitError:
            pass
    assert harmless < 1000


def test_compressed_files_are_read_and_their_damage_found(table, saved, folder):
    with np.load(io.BytesIO(saved)) as file:
        arrays = {name: file[name] for name in file.files}
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    np.testing.assert_array_equal(load(out.getvalue(), folder).values, table.values)
    rng = random.Random(8)
    for _ in range(300):
        data = bytearray(out.getvalue())
        data[rng.randrange(len(data) // 2)] ^= 0xFF
        try:
            load(bytes(data), folder)
        except EcfitError:
            continue


def test_arrays_must_have_the_shape_of_the_axes():
    axis = Axis.given("mu", [0.0, 1.0])
    with pytest.raises(EcfitError, match=r"values have shape \(3,\), the axes say \(2,\)"):
        Table(np.zeros(3), np.zeros(2), np.zeros(2, np.int8), (axis,), Contract("unknown"), 1e-7)


def test_arrays_cannot_be_changed_afterwards(table):
    with pytest.raises(ValueError, match="read-only"):
        table.values[0, 0] = 3.0


def test_the_description_warns_of_what_did_not_converge(table):
    text = "\n".join(table.describe())
    assert "3 x 4 entries of directional-albedo" in text
    assert "WARNING: 1 entries: the finest rule's error estimate exceeds the tolerance" in text
    assert "WARNING: 2 entries: the integral is NaN or infinite" in text
    where = [line.partition(", ")[2] for line in table.describe() if "WARNING" in line]
    for words, status in zip(where, (Status.TOLERANCE_NOT_MET, Status.NOT_FINITE), strict=True):
        found = np.flatnonzero(table.status == status)
        places = [", ".join(f"{n} = {x[0]:.4g}" for n, x in table.grid.nodes_at(found[[i]]).items()) for i in
                  range(found.size)]  # fmt: skip
        assert words in [f"{'it is' if found.size == 1 else 'the worst'} at {place}" for place in places]
    counts = {Status.CONVERGED: 9, Status.TOLERANCE_NOT_MET: 1, Status.NOT_FINITE: 2, Status.GIVEN: 0}
    assert table.counts() == counts
    np.testing.assert_array_equal(table.usable, np.isfinite(table.values))


def test_a_converged_table_warns_of_nothing(paper_table):
    assert not [line for line in paper_table.describe() if "WARNING" in line]


def test_the_public_name_loads_too(saved, folder, table):
    path = folder / "public.npz"
    path.write_bytes(saved)
    np.testing.assert_array_equal(ecfit.Table.load(str(path)).values, table.values)
