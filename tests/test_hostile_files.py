"""Files that are made to hurt: nested, long, packed, linked. Each is refused at once, in little memory."""

import io
import json
import os
import re
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import guarded, settled

import ecfit
from ecfit.config import read_config
from ecfit.errors import EcfitError
from ecfit.files import clear_parts, read_json, write_json, write_text

DEEP = 10_000
STUDY = 'name = "x"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{STUDY}a = {'[' * DEEP}{']' * DEEP}", "nested too deeply"),
        (f"{STUDY}a = {'{a = ' * DEEP}1{'}' * DEEP}", "nested too deeply"),
        (f"{STUDY}{'.'.join(['a'] * DEEP)} = 1", "nested too deeply"),
        (f"{STUDY}[{' . '.join(['a'] * DEEP)}]\nb = 1", "nested too deeply"),
        (f"{STUDY}[{'.'.join(['a'] * 40)}]\nb = 1", "2: a: unknown key"),
        (f"{STUDY}a = {'9' * 5000}", "a whole number of thousands of digits"),
        (f'name = "{"x" * 10**6}"', "1000009 characters, a study has at most 1000000"),
        (f'name = "{"x" * 10**5}"', "1: name: 'x{199}[.]{3}: expected a plain word"),
        (STUDY + "".join(f"k{i} = 1\n" for i in range(4000)), "k49: unknown key.*\n... and more faults"),
        (STUDY + "[[tables]]\n" * 5000, "and more faults than these"),
        (STUDY + STUDY, "Cannot overwrite a value"),
        (STUDY + "tables = [1e400, nan]", "tables: inf: should be a valid table"),
    ],
)
def test_studies(tmp_path: Path, text: str, message: str):
    path = tmp_path / "a.toml"
    path.write_text(text)
    said: list[str] = []

    def call() -> None:
        try:
            read_config(path)
        except EcfitError as error:
            said.append(str(error))
            raise

    with guarded(tmp_path):
        assert not settled(call)
    assert re.search(message, said[0])
    assert len(said[0]) < 20_000


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * DEEP + "]" * DEEP, "recursion"),
        ('{"a":' * DEEP + "1" + "}" * DEEP, "recursion"),
        ("9" * 5000, "a whole number of thousands of digits"),
        ("[1, 2", "Expecting"),
    ],
)
def test_json(tmp_path: Path, text: str, message: str):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(EcfitError, match=message):
        read_json(tmp_path / "a.json")


@pytest.mark.parametrize("number", ["1e400", "-1e400", "NaN", "Infinity", "9" * 400])
def test_coefficients_that_no_float_holds_are_refused(tmp_path: Path, number: str):
    good = ecfit.published("sforza-pellacini-2022-conductor").to_dict()
    text = json.dumps(good)
    first = json.dumps(good["coefficients"][0])
    path = tmp_path / "fit.json"
    path.write_text(text.replace(f'"coefficients": [{first}', f'"coefficients": [{number}', 1))
    with pytest.raises(EcfitError, match="finite|number|large"):
        ecfit.Approximation.from_dict(read_json(path))


def test_of_keys_that_come_twice_the_last_counts(tmp_path: Path):
    """As JSON's readers have it: the same for every command, so that nothing is judged by the other one."""
    good = ecfit.published("sforza-pellacini-2022-conductor").to_dict()
    text = json.dumps(good)
    (tmp_path / "fit.json").write_text('{"coefficients": [1.0], ' + text[1:])
    found = ecfit.Approximation.from_dict(read_json(tmp_path / "fit.json"))
    np.testing.assert_array_equal(found.coefficients, good["coefficients"])


@pytest.fixture
def table(tmp_path: Path) -> dict[str, np.ndarray]:
    """The arrays of a table's file."""
    ecfit.Table.from_array(np.eye(3), {"r": 3, "mu": 3}, {"model": "unknown"}).save(tmp_path / "t.npz")
    with np.load(tmp_path / "t.npz") as file:
        return {name: file[name] for name in file.files}


def npy(shape: tuple[int, ...]) -> bytes:
    """An array's file that has a shape and nothing else."""
    out = io.BytesIO()
    np.lib.format.write_array_header_1_0(out, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return out.getvalue()


def refused_in_little_memory(path: Path, message: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(EcfitError, match=message):
            ecfit.Table.load(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", ["values", "status", "nodes_0", "header"])
def test_archives_whose_members_unpack_to_far_more(tmp_path: Path, table: dict[str, Any], name: str):
    """50 MB of zeros in 50 kB; with gigabytes it is the same line that refuses."""
    path = tmp_path / "bomb.npz"
    zeros = np.array("\0" * 12_500_000 + "x") if name == "header" else np.zeros(6_250_000)
    np.savez_compressed(path, **{**table, name: zeros})
    assert path.stat().st_size < 200_000
    refused_in_little_memory(path, rf"'{name}' has 50\d+ bytes unpacked, at most \d+ belong there")


@pytest.mark.parametrize("shape", [(10**15,), (2**62, 4), (10**6, 10**6), (0, 10**18)])
@pytest.mark.parametrize("name", ["values", "nodes_1"])
def test_headers_that_promise_more_than_there_is(
    tmp_path: Path, table: dict[str, Any], name: str, shape: tuple[int, ...]
):
    path = tmp_path / "t.npz"
    np.savez(path, **{key: array for key, array in table.items() if key != name})
    with zipfile.ZipFile(path, "a") as file:
        file.writestr(f"{name}.npy", npy(shape))
    with guarded(tmp_path):
        assert not settled(lambda: ecfit.Table.load(path), seconds=5)


@pytest.mark.skipif(not hasattr(os, "symlink"), reason="no symbolic links here")
@pytest.mark.parametrize("write", [lambda p: write_text(p, "new"), lambda p: write_json(p, [1])])
def test_a_link_in_the_results_is_replaced_and_never_written_through(
    tmp_path: Path, write: Callable[[Path], None]
):
    outside = tmp_path / "outside.txt"
    outside.write_text("theirs")
    results = tmp_path / "results"
    results.mkdir()
    for name, target in (("summary.csv", outside), ("gone.csv", tmp_path / "nowhere")):
        (results / name).symlink_to(target)
        write(results / name)
        assert not (results / name).is_symlink()
    assert outside.read_text() == "theirs"
    assert not (tmp_path / "nowhere").exists()
    (results / ".x.part").symlink_to(outside)
    os.utime(outside, (0, 0))
    clear_parts(results)
    assert not (results / ".x.part").is_symlink()
    assert outside.read_text() == "theirs"
