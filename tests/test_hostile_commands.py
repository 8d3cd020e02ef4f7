"""Commands: whatever the arguments, the end is an answer or one message, never a traceback."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hostile import TEXTS, guarded, many, settled, tried
from hypothesis import strategies as st

from ecfit import Table, cli, write_table
from ecfit.errors import EcfitError

# Names that lead to hours of work are left out: what is asked here is refused, or small.
WORDS = [
    *[t for t in TEXTS if len(t) < 60 and "ecfit-escaped" not in t],
    "conductor", "lambertian", "kulla-conty-2017", "t.npz", "theirs.csv", "study.toml", "bad.toml",
    "fit.json", "no",
    "mu=2", "r=2", "r=0:1:2", "mu=0.1,0.5", "mu=", "=3", "mu=0:0:2", "mu=nan:1:2", "mu=1:0:2", "mu=-1",
    "mu=0", "mu=1",
    "mu=1e9", "mu=99999999999999999999", "F0=2", "masking=separable", "masking=x", "F0=0.5", "out.npz",
    "out.json",
    "-1", "cycles", "three", "t.h", "glsl", "out.h", "conductor-10", "starter", "out.toml",
]  # fmt: skip
OPTIONS = [
    "--axis", "--option", "--plugin", "--output", "--results", "--degree", "--form", "--stored", "--scale",
    "--order",
    "--channel", "--quantity", "--lobe", "--transport", "--tolerance", "--spacing", "--exponent",
    "--workers", "--seed",
    "--numerator", "--denominator", "--guarded", "--no-guarded", "--model", "--entries", "--refits",
    "--samples", "--",
    "-", "--version", "-x", "--axis=mu=2", "--degree=1", "--tolerance=0.9", "--samples=1",
    "--layout", "--piece", "--number", "--parts", "--name", "--layout=cycles", "--lang=glsl", "--like",
    "--coordinates", "--least", "--derivative", "--clamp", "--points", "--tool",
]  # fmt: skip
# `run` and `ship` of a good study, and a certificate, are minutes, and compilers are processes: these have
# their own tests.
COMMANDS = [
    "table",
    "import",
    "fit",
    "report",
    "list",
    "check-bsdf",
    "verify",
    "run",
    "ship",
    "certify",
    "furnace",
    "check",
    "export-table",
    "export",
    "compare",
    "init",
    "check-export --tool none",
    "x",
]

arguments = st.tuples(
    st.sampled_from(COMMANDS),
    st.lists(st.one_of(st.sampled_from(WORDS), st.sampled_from(OPTIONS), st.text(max_size=8)), max_size=9),
).map(lambda found: [*found[0].split(), *found[1]])


def folder_of_files(folder: Path) -> Path:
    np.savetxt(folder / "theirs.csv", np.array([[0.9, 0.8], [0.7, 0.6]]), delimiter=",")
    (folder / "t.npz").write_bytes(b"PK\x03\x04")
    (folder / "bad.toml").write_text('name = "x"\n[[tables]]\nname = "../x"\n')
    (folder / "study.toml").write_text("name = \n")
    (folder / "fit.json").write_text("{}")
    # What a file says of itself is right; its numbers are of no model.
    write_table(Table.from_array([[0.9, 0.8], [0.7, 0.6]], {"r": 2, "mu": 2}, {}), folder / "t.h")
    return folder


def call(given: list[str]) -> int:
    """The exit code."""
    try:
        cli.main(given)
    except SystemExit as stop:
        if stop.code is None:
            return 0
        return stop.code if isinstance(stop.code, int) else -1
    return 0


@many(50, 1000)
def test_arguments_of_any_kind_end_in_an_answer_or_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], cases: int
):
    monkeypatch.chdir(folder_of_files(tmp_path))
    codes: list[int] = []

    def case(given: list[str]) -> None:
        ended: list[int] = []
        settled(lambda: ended.append(call(given)), seconds=60)
        out, err = capsys.readouterr()
        codes.extend(ended)
        assert ended in ([0], [1], [2])
        assert "Traceback" not in out + err
        if ended == [2]:
            assert len([line for line in err.splitlines() if line.startswith("error: ")]) == 1

    with guarded(tmp_path):
        tried(cases, arguments, case)
    assert codes.count(2) > cases // 2


@pytest.mark.slow
def test_a_hundred_calls_of_the_program_leave_no_traceback(tmp_path: Path):
    folder_of_files(tmp_path)
    seen: list[list[str]] = []

    def case(given: list[str]) -> None:
        if not any("\x00" in word or "\ud7ff" < word < "\ue000" for word in given):
            seen.append(given)

    tried(400, arguments, case)
    assert len(seen) >= 100
    for given in seen[-100:]:
        words = [word.encode("utf-8", "replace").decode() for word in given]
        done = subprocess.run(
            [sys.executable, "-c", "from ecfit.cli import main; main()", *words],
            capture_output=True, text=True, cwd=tmp_path, timeout=120, errors="replace",
        )  # fmt: skip
        assert done.returncode in (0, 1, 2), (words, done.stderr)
        assert "Traceback" not in done.stderr + done.stdout, (words, done.stderr)


def test_the_error_of_a_mistake_is_what_the_command_prints(capsys: pytest.CaptureFixture[str]):
    from ecfit.approximation import find

    with pytest.raises(EcfitError) as caught:
        find("no")
    assert call(["certify", "no"]) == 2
    assert str(caught.value) in capsys.readouterr().err
