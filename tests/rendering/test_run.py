"""A tiny furnace, rendered: its numbers are those of the integral, and what is finished is kept."""

import csv
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from ecfit import cli
from ecfit.rendering import _mitsuba
from ecfit.rendering.pictures import percent

CONFIG = """\
name = "tiny"
r = [1.0]
pixels = 24
samples = 32
[[rows]]
name = "none"
[[rows]]
name = "ecfit"
conductor = ["conductor-20"]
[[materials]]
name = "white"
model = "conductor"
"""
# E_avg of alpha = 1 over the part of the sphere with mu >= 0.1, by `ecfit furnace tiny.toml --numerical`.
LOST = 0.625


def furnace(capsys, folder: Path, *more: str) -> tuple[int, str, str]:
    path = folder / "tiny.toml"
    path.write_text(CONFIG)
    code = 0
    try:
        cli.main(["furnace", str(path), "--results", str(folder / "results"), *more])
    except SystemExit as stop:
        code = int(stop.code or 0)
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.skipif(find_spec("mitsuba") is None, reason="mitsuba is not installed (extra 'render')")
def test_a_tiny_furnace(capsys, tmp_path):
    code, out, err = furnace(capsys, tmp_path)
    assert code == 0, err
    assert "2 rendered, 0 found" in out
    folder = tmp_path / "results" / "tiny"
    none, ours = csv.DictReader((folder / "furnace.csv").read_text().splitlines())
    for row, expected in ((none, -LOST), (ours, 0.0)):
        assert abs(float(row["energy"]) - expected) < 5.0 * float(row["noise"]) + 5e-3
        assert float(row["rest"]) == 0.0
    assert float(ours["mean"]) < 0.05
    assert (folder / "white.png").read_bytes().startswith(b"\x89PNG")
    assert "white.png" in (folder / "furnace.md").read_text()

    before = {path: path.read_bytes() for path in folder.glob("*.*")}
    code, out, _ = furnace(capsys, tmp_path)
    assert (code, "0 rendered, 2 found" in out) == (0, True)
    assert before == {path: path.read_bytes() for path in folder.glob("*.*")}


def test_without_mitsuba_one_line_says_how_to_get_it(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    code, _, err = furnace(capsys, tmp_path)
    assert code == 2
    assert err.strip() == f"error: {_mitsuba.REMEDY}"


def test_a_model_needs_axes_and_says_so(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["furnace", "conductor"])
    assert stop.value.code == 2
    assert "needs --axis" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.6249, "62.5%"),
        (0.0123, "1.23%"),
        (0.000123, "0.01%"),
        (0.0, "0.00%"),
        (13.0, "> 1000%"),
        (float("inf"), "not finite"),
        (float("nan"), "not finite"),
    ],
)
def test_percentages_have_three_digits_at_most(value, text):
    assert percent(value) == text
