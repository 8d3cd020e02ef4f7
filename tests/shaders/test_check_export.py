"""`ecfit check-export`: what it prints, and its exit codes."""

import json
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from ecfit import cli
from ecfit.approximation import Lookup, shipped
from ecfit.errors import EcfitError
from ecfit.shaders.cases import case
from ecfit.shaders.compilers import CC
from ecfit.shaders.devices import NoDevice
from ecfit.shaders.tools import TOOLS, Tool

checks = import_module("ecfit.shaders.check")  # the name in the package is the function's


def call(capsys, *arguments):
    code = 0
    try:
        cli.main([str(a) for a in arguments])
    except SystemExit as stop:
        code = stop.code
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def written(approximation, path):
    path.write_text(json.dumps(approximation.to_dict()))
    return path


@pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))
def test_a_fit_that_is_right(capsys):
    code, out, _ = call(capsys, "check-export", "conductor-7", "--tool", "cc", "--points", 64)
    assert code == 0
    assert out.startswith("cc (c): run: 1 functions on ")
    assert "all right" in out
    assert "conductor_7: at most 0 ulps from NumPy's float32" in out


@pytest.mark.parametrize(("asked", "expected"), [(["--tool", "cc"], 1), ([], 0)])
def test_a_tool_that_is_not_there_is_a_fault_if_it_was_asked_for(capsys, monkeypatch, asked, expected):
    monkeypatch.setattr(Tool, "missing", lambda _: "no cc: a C compiler")
    code, out, _ = call(capsys, "check-export", "conductor-7", *asked)
    assert code == expected
    assert "cc (c): not here: no cc: a C compiler" in out


def test_a_device_that_is_not_there_is_a_fault_if_it_was_asked_for(capsys, monkeypatch):
    def none(*_):
        raise NoDevice("the driver webgpu finds no device")

    monkeypatch.setattr(checks, "compare", none)
    monkeypatch.setattr(Tool, "missing", lambda _: None)
    code, out, _ = call(capsys, "check-export", "conductor-7", "--tool", "webgpu")
    assert code == 1
    assert out == "webgpu (wgsl): not here: the driver webgpu finds no device\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--tool", "glslx"], "unknown tool 'glslx'"),
        (["no-such-fit"], "no-such-fit"),
        (["conductor-7", "--points", "10"], "10 points are too few"),
        (["TABLE"], "a table is not a formula"),
        (["conductor-7", "OTHER"], "two different approximations are called 'conductor_7'"),
    ],
)
def test_mistakes_are_one_line_and_exit_code_2(capsys, tmp_path, arguments, said):
    """Nothing of them is left to the tools to say, each of its own."""
    fit = shipped("conductor-7")
    formula = Lookup(np.full((3, 4), 0.5), ((0.0, 1.0), (0.0, 1.0)), ("identity", "square"))
    written(replace(fit, formula=formula), tmp_path / "TABLE.json")
    written(replace(shipped("conductor-10"), name="conductor-7"), tmp_path / "OTHER.json")
    given = [str(tmp_path / f"{a}.json") if a.isupper() else a for a in arguments]
    code, out, err = call(capsys, "check-export", *given)
    assert (code, out) == (2, "")
    assert said in err


@pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))
def test_what_is_named_twice_is_checked_once(capsys, tmp_path):
    same = written(shipped("conductor-7"), tmp_path / "same.json")
    twice = ["conductor-7", "conductor-7", same, "--tool", "cc", "--tool", "cc"]
    code, out, _ = call(capsys, "check-export", *twice, "--points", 64)
    assert code == 0
    assert out.count("cc (c): run: 1 functions on ") == 1


def test_a_fault_is_told_and_ends_with_exit_code_1(capsys, monkeypatch):
    def refuse(*_):
        raise EcfitError("cc refuses the exported code: line 3")

    monkeypatch.setattr(checks, "compare", refuse)
    monkeypatch.setattr(type(TOOLS["cc"]), "missing", lambda _: None)
    code, out, _ = call(capsys, "check-export", "conductor-7", "--tool", "cc")
    assert code == 1
    assert out == "cc (c): failed: cc refuses the exported code: line 3\n"


def test_too_few_points_for_the_corners_are_refused():
    with pytest.raises(EcfitError, match="too few for all corners: take 32 or more"):
        case(shipped("conductor-7"), "c").points(31, 1)


@pytest.mark.parametrize("points", [-1, 31, 10**20])
def test_a_count_of_points_that_no_tool_takes_is_a_mistake(points, capsys):
    code, out, err = call(capsys, "check-export", "conductor-7", "--tool", "cc", "--points", points)
    assert (code, out) == (2, "")
    assert f"error: {points} points are too " in err
