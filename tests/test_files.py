"""Files: whole or not at all, and clear errors."""

import json
import math

import pytest

from ecfit.errors import EcfitError
from ecfit.files import make_folder, read_json, read_text, write_atomically, write_json, write_text


def test_text_and_json_read_back(tmp_path):
    path = tmp_path / "deep" / "folder" / "a.json"
    write_json(path, {"é": [1.0, 1e-300, 0.1 + 0.2], "n": None, "t": (1, 2)})
    assert read_json(path) == {"é": [1.0, 1e-300, 0.1 + 0.2], "n": None, "t": [1, 2]}
    write_text(path, "á\n")
    assert read_text(path) == "á\n"


def test_json_holds_only_what_json_knows(tmp_path):
    write_json(tmp_path / "a.json", {"a": math.nan, "b": [math.inf, {"c": -math.inf}]})
    text = (tmp_path / "a.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail) == {"a": None, "b": [None, {"c": None}]}


@pytest.mark.parametrize("fault", [ValueError, KeyboardInterrupt, MemoryError])
def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path, fault):
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def write(file):
        file.write(b"half of the n")
        raise fault

    with pytest.raises(fault):
        write_atomically(path, write)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_an_error_that_names_the_file(tmp_path):
    def write(file):
        raise OSError(28, "No space left on device")

    with pytest.raises(EcfitError, match=r"cannot write '.*a\.txt': No space left"):
        write_atomically(tmp_path / "a.txt", write)
    assert list(tmp_path.iterdir()) == []


def test_files_are_readable_by_others(tmp_path):
    write_text(tmp_path / "a.txt", "x")
    assert (tmp_path / "a.txt").stat().st_mode & 0o444 == 0o444


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path):
    write_text(tmp_path / "a", "x")
    with pytest.raises(EcfitError, match="cannot create the folder"):
        make_folder(tmp_path / "a" / "b")
    with pytest.raises(EcfitError, match="cannot create the folder"):
        write_text(tmp_path / "a" / "b" / "c.txt", "x")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe", "not a text file"),
        (b"", "not valid JSON"),
        (b"{", "not valid JSON"),
        (b"[" * 100_000, "not valid JSON"),
    ],
)
def test_broken_json_is_named(tmp_path, content, message):
    (tmp_path / "a.json").write_bytes(content)
    with pytest.raises(EcfitError, match=message) as caught:
        read_json(tmp_path / "a.json")
    assert "a.json" in str(caught.value)


def test_missing_files_and_folders_are_named(tmp_path):
    with pytest.raises(EcfitError, match=r"no such file: '.*none\.json'"):
        read_text(tmp_path / "none.json")
    with pytest.raises(EcfitError, match="cannot read"):
        read_text(tmp_path)
