"""Tables: whatever an NPZ, NPY, CSV or EXR file holds, reading and using it ends, and executes nothing."""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from hostile import OUTSIDE, UPWARDS, changed, changes, damaged, damages, guarded, many, settled, tried
from hypothesis import strategies as st

import ecfit
from ecfit.tables import read_table

VALUES = 1.0 - np.linspace(0.0, 0.5, 12).reshape(3, 4)
AXES = {"r": 3, "mu": ecfit.Axis.spaced("mu", 4, spacing="texel-centre")}


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table of ours."""
    path = tmp_path_factory.mktemp("npz") / "t.npz"
    ecfit.Table.from_array(VALUES, AXES, {"model": "conductor", "parameters": {"a": 1.0}}).save(path)
    return path


def use(path: Path) -> None:
    """What commands do with a table."""
    table = ecfit.Table.load(path)
    assert table.describe()
    table.remarks()
    table.counts()
    assert len(table.digest) == 64
    json.dumps(table.contract.to_dict())
    table.save(path.with_name("again.npz"))


@many(60, 1000)
def test_damaged_bytes_of_our_tables(tmp_path: Path, saved: Path, cases: int):
    path, good = tmp_path / "t.npz", saved.read_bytes()

    def case(damage: Any) -> None:
        path.write_bytes(damaged(good, damage))
        settled(lambda: use(path))

    with guarded(tmp_path):
        tried(cases, damages, case)


@many(40, 1000)
def test_changed_headers_of_our_tables(tmp_path: Path, saved: Path, cases: int):
    path = tmp_path / "t.npz"
    with np.load(saved) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(str(arrays["header"]))
    used = 0

    def case(made: list[Any]) -> None:
        nonlocal used
        np.savez(path, **{**arrays, "header": np.array(json.dumps(changed(header, made)))})
        used += settled(lambda: use(path))

    with guarded(tmp_path):
        tried(cases, changes, case)
    assert used > 0


@many(20, 500)
def test_members_of_our_tables_with_hostile_names(tmp_path: Path, saved: Path, cases: int):
    """An archive may hold members that would be written elsewhere if they were unpacked: nothing is."""
    import zipfile

    path = tmp_path / "t.npz"
    names = st.sampled_from([f"{UPWARDS}.npy", f"{OUTSIDE}.npy", "C:\\x.npy", "values.npy", "a/b"])

    def case(example: tuple[str, bytes]) -> None:
        path.write_bytes(saved.read_bytes())
        with zipfile.ZipFile(path, "a") as file:
            if example[0] not in file.namelist():
                file.writestr(example[0], example[1])
        settled(lambda: use(path))

    with guarded(tmp_path):
        tried(cases, st.tuples(names, st.binary(max_size=30)), case)


def _exr(path: Path) -> None:
    pixels = VALUES.astype(np.float32)
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"R": pixels, "G": pixels.copy()}).write(str(path))


def _npy(path: Path) -> None:
    np.save(path, VALUES)


def _matrix(path: Path) -> None:
    np.savetxt(path, VALUES, delimiter=",")


def _long(path: Path) -> None:
    rows = [f"{r},{mu},{v}" for r, line in zip((0.0, 0.5, 1.0), VALUES, strict=True)
            for mu, v in zip((0.125, 0.375, 0.625, 0.875), line, strict=True)]  # fmt: skip
    path.write_text("\n".join(["r,mu,value", *rows]))


@pytest.mark.parametrize(
    ("ending", "write"), [("npy", _npy), ("exr", _exr), ("csv", _matrix), ("csv", _long)]
)
@many(30, 500)
def test_damaged_bytes_of_others_tables(
    tmp_path: Path, ending: str, write: Callable[[Path], None], cases: int
):
    path = tmp_path / f"t.{ending}"
    write(path)
    good = path.read_bytes()
    assert settled(lambda: read_table(path, AXES, {"model": "unknown"}))

    def case(damage: Any) -> None:
        path.write_bytes(damaged(good, damage))
        settled(lambda: read_table(path, AXES, {"model": "unknown"}))

    with guarded(tmp_path):
        tried(cases, damages, case)


@many(40, 1000)
def test_text_of_any_kind_as_a_table(tmp_path: Path, cases: int):
    path = tmp_path / "t.csv"
    cells = st.sampled_from(["0.5", "1", "nan", "inf", "1e999", "-", "", "r", "mu", "value", "x", "#",
    '"', "\ufeff", "é",
                             "=cmd()", "0x10", "1_0", "١", "\x00", " "])  # fmt: skip
    ends = st.sampled_from([",", ";", "\t", " ", "\n", "\n", "\r\n", "\r", "\x0b", "\u2028"])
    text = st.lists(st.tuples(cells, ends), max_size=40).map(lambda found: "".join(a + b for a, b in found))

    def case(content: str) -> None:
        path.write_text(content, encoding="utf-8")
        settled(lambda: read_table(path, AXES, {"model": "unknown"}))

    with guarded(tmp_path):
        tried(cases, text, case)


@many(20, 500)
def test_npy_headers_of_any_kind(tmp_path: Path, cases: int):
    """The header of an NPY file is a Python literal: it is parsed, never executed."""
    path = tmp_path / "t.npy"
    pieces = st.sampled_from(["{", "}", "'descr': ", "'<f8'", "'|O'", "'fortran_order': ", "False",
    "'shape': ", "(3, 4)",
                              "(-1,)", "(10**9,)", ", ", "__import__('os').system('touch x')",
                              "[('a', '<f8')]", "\n",
                              "'<U999999999'", "lambda: 0", "("])  # fmt: skip

    def case(found: list[str]) -> None:
        header = ("".join(found) + "\n").encode("latin-1")
        out = io.BytesIO(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + VALUES.tobytes())
        path.write_bytes(out.getvalue())
        settled(lambda: read_table(path, AXES, {"model": "unknown"}))

    with guarded(tmp_path):
        tried(cases, st.lists(pieces, max_size=14), case)
