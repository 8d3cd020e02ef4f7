"""`ecfit check-export`: what it prints, and its exit codes."""

from importlib import import_module

import pytest

from ecfit import cli
from ecfit.approximation import shipped
from ecfit.errors import EcfitError
from ecfit.shaders.compilers import CC
from ecfit.shaders.tools import TOOLS

checks = import_module("ecfit.shaders.check")  # the name in the package is the function's


def call(capsys, *arguments):
    code = 0
    try:
        cli.main([str(a) for a in arguments])
    except SystemExit as stop:
        code = stop.code
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))
def test_a_fit_that_is_right(capsys):
    code, out, _ = call(capsys, "check-export", "conductor-7", "--tool", "cc", "--points", 64)
    assert code == 0
    assert out.startswith("cc (c): run: 1 functions on ")
    assert "all right" in out
    assert "conductor_7: at most 0 ulps from NumPy's float32" in out


def test_a_tool_that_is_not_there_is_no_fault(capsys, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    code, out, _ = call(capsys, "check-export", "conductor-7", "--tool", "cc")
    assert code == 0
    assert "not here: no cc: a C compiler" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--tool", "glslx"], "unknown tool 'glslx'"),
        (["no-such-fit"], "no-such-fit"),
    ],
)
def test_mistakes_are_one_line_and_exit_code_2(capsys, arguments, said):
    code, _, err = call(capsys, "check-export", *arguments)
    assert code == 2
    assert said in err


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
        checks.case(shipped("conductor-7"), "c").points(31, 1)


@pytest.mark.parametrize("points", [-1, 31, 10**20])
def test_a_count_of_points_that_no_tool_takes_is_a_mistake(points, capsys):
    code, out, err = call(capsys, "check-export", "conductor-7", "--tool", "cc", "--points", points)
    assert (code, out) == (2, "")
    assert f"error: {points} points are too " in err
