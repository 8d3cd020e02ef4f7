"""The command line: what it prints, and that every mistake is one message and exit code 2."""

import inspect
import json
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import ecfit
from ecfit import cli
from ecfit.cli.overview import COMMANDS, name_of

ROOT = Path(__file__).parent.parent


def call(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    """(exit code, stdout, stderr) of `ecfit arguments`, in this process."""
    code = 0
    try:
        cli.main([str(a) for a in arguments])
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 1
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.parametrize(
    ("command", "heavy"),
    [
        ("--help", "jax numpy matplotlib pydantic rich cyclopts docstring_parser ecfit.cli.studies"),
        ("--version", "jax numpy matplotlib pydantic rich cyclopts ecfit.cli.studies"),
        ("init --help", "jax numpy matplotlib pydantic ecfit.cli.tables"),
        ("compare results/quick results/quick", "jax numpy matplotlib pydantic rich ecfit.cli.tables"),
        ("run nowhere.toml", "jax matplotlib ecfit.cli.tables"),
        ("rum", "jax numpy matplotlib pydantic docstring_parser"),
    ],
)
def test_what_a_command_does_without_is_not_loaded(command: str, heavy: str):
    program = (
        "import sys; from ecfit import cli\n"
        f"try: cli.main({command.split()!r})\nexcept SystemExit: pass\n"
        f"print('loaded:', *({set(heavy.split())!r} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.splitlines()[-1:] == ["loaded:"], done.stderr


def commands() -> list[tuple[str, str]]:
    """(name, import path) of every command."""
    return [
        (name_of(found.partition(":")[2]), f"ecfit.cli.{found}")
        for theme in COMMANDS.values()
        for found in theme
    ]


@pytest.mark.parametrize("words", [(), ("--help",), ("-h",), ("--help", "--version")])
def test_help_says_what_every_command_does(capsys: pytest.CaptureFixture[str], words: tuple[str, ...]):
    code, out, _ = call(capsys, *words)
    assert code == 0
    assert max(map(len, out.splitlines())) <= 100
    flat = " ".join(out.split())
    for name, path in commands():
        module, _, function = path.partition(":")
        first = getattr(import_module(module), function).__doc__.partition("\n")[0]
        assert f" {name} {first}" in flat


@pytest.mark.parametrize(("name", "path"), commands())
def test_the_help_of_a_command_shows_what_it_takes(capsys: pytest.CaptureFixture[str], name: str, path: str):
    code, out, _ = call(capsys, name, "--help")
    assert code == 0
    assert out.startswith(f"Usage: ecfit {name}")
    module, _, function = path.partition(":")
    flat = " ".join(out.replace("│", " ").split())
    for taken in inspect.signature(getattr(import_module(module), function)).parameters:
        assert f"--{taken.replace('_', '-')} " in f"{flat} " or taken.upper() in flat, taken


def test_list_names_models_forms_and_published_fits_with_sources(capsys: pytest.CaptureFixture[str]):
    code, out, _ = call(capsys, "list")
    assert code == 0
    for word in ("conductor", "masking = separable | height-correlated", "lambertian", "rational", "eq. 24"):
        assert word in out


def test_import_then_fit(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    """A 16-bit list of 1 - E, roughness fastest, from somebody's renderer."""
    theirs, table = tmp_path / "theirs.csv", tmp_path / "t.npz"
    rows = [[round(65535 * 0.4 * (i / 5) ** 2 * (1 - j / 14)) for i in range(6)] for j in range(8)]
    theirs.write_text("\n".join(", ".join(map(str, row)) + "," for row in rows))
    arguments = ["import", theirs, "--stored", "1-E", "--scale", "65535", "--order", "mu,r", "--axis", "r=6"]
    code, out, err = call(capsys, *arguments, "--axis", "mu=0:1:8", "--output", table)
    assert (code, err) == (0, "")
    assert "given, not integrated here: no error estimate (source: theirs.csv)" in out
    assert "WARNING" not in out
    code, out, _ = call(capsys, "fit", table, "--form", "polynomial", "--degree", "3")
    assert code == 0
    assert "10 coefficients, converged" in out
    pytest.importorskip("scipy")
    code, out, _ = call(capsys, "fit", table, "--form", "polynomial", "--degree", "1", "--lower-bound")
    assert code == 0
    assert "times the least possible" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("none.csv", "--axis", "r=6"), ("no such file",)),
        (("t.csv", "--axis", "r=6"), ("'t.csv' holds 3 numbers", "r = 6")),
        (("t.csv", "--axis", "ior=3"), ("'ior' has no range",)),
        (("t.csv", "--axis", "r=0.1,0.5"), ("'t.csv' holds 1 x 3 numbers",)),
        (("t.csv", "--axis", "r=0.5,0.1,1"), ("must increase",)),
        (("t.csv", "--axis", "r=0.5,x,1"), ("list of numbers",)),
        (("t.csv", "--axis", "r"), ("name=count",)),
        (("t.csv", "--axis", "r=3", "--stored", "1E"), ("--stored",)),
        (("t.csv", "--axis", "r=3", "--spacing", "centre"), ("--spacing",)),
        (("t.csv", "--axis", "r=3", "--order", "mu"), ("order must name",)),
        (("t.csv", "--axis", "r=3", "--model", "conducter"), ("did you mean 'conductor'",)),
        (("t.csv", "--axis", "r=3", "--quantity", "albedo"), ("directional-albedo",)),
    ],
)  # fmt: skip
def test_an_import_that_cannot_be_is_one_message(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments, words
):
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text("0.9, 0.8, 0.7\n")
    code, out, err = call(capsys, "import", *arguments, "--output", "t.npz")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert len(err.splitlines()) == 1
    for word in words:
        assert word in err
    assert not Path("t.npz").exists()


def test_table_then_fit(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    table, fit = tmp_path / "e.npz", tmp_path / "e.json"
    code, out, _ = call(
        capsys, "table", "conductor", "--axis", "r=8", "--axis", "mu=0.1:1:8", "--output", table
    )
    assert code == 0
    assert "8 x 8 entries" in out
    code, out, _ = call(capsys, "fit", table, "--form", "polynomial", "--degree", "2", "--output", fit)
    assert code == 0
    assert "6 coefficients, converged" in out
    saved = json.loads(fit.read_text())
    assert saved["variables"] == ["r", "mu"]
    assert saved["domain"] == [[0.0, 1.0], [0.1, 1.0]]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "nowhere.toml"), ("no such file", "nowhere.toml")),
        (("rum",), ("rum", "run")),
        (("run",), ("config",)),
        (("run", "nowhere.toml", "--workers", "0"), ("workers", "1 or more")),
        (("run", "nowhere.toml", "--workers", "two"), ("workers", "two")),
        (("table", "condcutor", "--axis", "mu=4", "--output", "x"), ("did you mean 'conductor'",)),
        (("table", "conductor", "--axis", "r=0:2:4", "--axis", "mu=4", "--output", "x"), ("domain",)),
        (("table", "conductor", "--axis", "r=4", "--output", "x.npz"), ("needs the axis 'mu'",)),
        (("table", "conductor", "--axis", "mu", "--output", "x.npz"), ("name=count",)),
        (("table", "conductor", "--option", "masking=x", "--axis", "mu=4", "--output", "x"), ("separable",)),
        (("table", "conductor", "--axis", "F0=4", "--axis", "mu=4", "--output", "x"), ("no effect", "unit")),
        (("table", "conductor", "--axis", "mu=4", "--output", "x", "--tolerance", "-1"), ("tolerance",)),
        (("fit", "nowhere.npz", "--degree", "3"), ("no such table",)),
        (("fit", "nowhere.npz"), ("--degree",)),
        (("check-bsdf", "ward", "--plugin", "nowhere.py"), ("no such file",)),
    ],
)  # fmt: skip
def test_mistakes_are_one_message_and_exit_code_2(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments, words
):
    monkeypatch.chdir(tmp_path)
    code, out, err = call(capsys, *arguments)
    assert code == 2
    assert out == ""
    for word in words:
        assert word in err
    message = [line for line in err.splitlines() if line.startswith("error: ")]
    assert len(message) == 1
    assert "Traceback" not in err


@pytest.mark.parametrize("degree", ["0", "200"])
def test_a_degree_out_of_range_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path, degree: str):
    table = tmp_path / "e.npz"
    call(capsys, "table", "lambertian", "--axis", "rho=4", "--axis", "mu=4", "--output", table)
    code, _, err = call(capsys, "fit", table, "--degree", degree)
    assert code == 2
    assert "1..20" in err


def test_a_truncated_table_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    table = tmp_path / "e.npz"
    call(capsys, "table", "lambertian", "--axis", "rho=4", "--axis", "mu=4", "--output", table)
    table.write_bytes(table.read_bytes()[:200])
    code, _, err = call(capsys, "fit", table, "--degree", "1")
    assert code == 2
    assert "damaged" in err


def test_check_bsdf_exits_with_1_where_a_property_fails(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    plugin = tmp_path / "bright.py"
    plugin.write_text(
        "import jax.numpy as jnp, ecfit\n"
        "@ecfit.register('bright')\n"
        "class Bright(ecfit.BSDF):\n"
        "    def f(self, wo, wi):\n"
        "        return jnp.where(wi[2] > 0.0, 2.0 / jnp.pi, 0.0)\n"
    )
    code, out, _ = call(capsys, "check-bsdf", "bright", "--plugin", plugin)
    assert code == 1
    assert "FAIL  energy <= 1" in out


def test_an_interrupt_says_how_to_go_on(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    from ecfit import study

    def interrupted(*_: object, **settings: object) -> None:
        assert settings["workers"] == 3
        raise KeyboardInterrupt

    monkeypatch.setattr(study, "run", interrupted)
    code, _, err = call(capsys, "run", ROOT / "configs" / "quick.toml", "--workers", 3)
    assert code == 130
    assert "the same command goes on from here" in err


def test_an_interrupt_promises_nothing_where_nothing_is_kept(monkeypatch, capsys):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(ecfit, "tabulate", interrupted)
    code, out, err = call(capsys, "table", "lambertian", "--axis", "mu=4", "--output", "t.npz")
    assert (code, out, err.splitlines()[-1]) == (130, "", "stopped")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["x.toml", "--albedo", "conductor-10", "--tolerance", "1e-3"], "leave out --albedo, --tolerance"),
        (["conductor", "--axis", "mu=4", "--numerical"], "leave out --numerical"),
    ],
)
def test_a_furnace_takes_nothing_in_vain(capsys, arguments, message):
    code, _, err = call(capsys, "furnace", *arguments)
    assert code == 2
    assert message in err


def test_a_pipe_that_is_closed_is_no_fault():
    """As in `ecfit --help | true`."""
    ends = os.pipe()
    os.close(ends[0])
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"}
    done = subprocess.run(
        [sys.executable, "-m", "ecfit", "--help"], stdout=ends[1], stderr=subprocess.PIPE, env=environment
    )
    os.close(ends[1])
    assert (done.returncode, done.stderr) == (0, b"")


def test_init_writes_a_study_once(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    path = tmp_path / "mine.toml"
    code, out, _ = call(capsys, "init", path)
    assert code == 0
    assert f"ecfit run {path}" in out
    code, _, err = call(capsys, "init", path)
    assert code == 2
    assert "exists" in err


def test_compare_exits_with_1_where_something_is_gone(capsys: pytest.CaptureFixture[str]):
    quick, paper = ROOT / "results/quick", ROOT / "results/paper"
    code, out, _ = call(capsys, "compare", quick, quick)
    assert code == 0
    assert "0 worse, 0 gone" in out
    code, out, _ = call(capsys, "compare", quick, paper)
    assert code == 1
    code, _, err = call(capsys, "compare", quick, ROOT)
    assert code == 2
    assert "no summary.csv" in err


def test_a_table_is_exported_imported_and_checked(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    """Exit codes of `ecfit check`: 0 as claimed, 1 not so, 2 a mistake."""
    header, table = tmp_path / "t.h", tmp_path / "t.npz"
    axes = ["--axis", "r=8", "--axis", "mu=8"]
    made = [
        "export-table",
        "conductor",
        "--layout",
        "yocto",
        *axes,
        "--tolerance",
        "1e-4",
        "--output",
        header,
    ]
    code, out, err = call(capsys, *made)
    assert code == 0
    assert "directional-albedo" in err  # its progress, and nothing else
    assert err.count("\n") == 1
    assert "8 x 8 numbers, float64 of E" in out
    code, out, _ = call(capsys, "import", header, "--output", table)
    assert code == 0
    assert "written" in out
    code, out, _ = call(capsys, "check", header)
    assert (code, "as claimed" in out) == (0, True)
    claims = ["--model", "conductor", "--axis", "alpha=8", "--axis", "mu=8"]
    code, out, _ = call(capsys, "check", header, *claims)
    assert code == 1
    assert "likely: r given as alpha: mean drift falls from" in out
    code, out, _ = call(capsys, "check", table)
    assert code == 0
    for wrong in (
        ["check", header, "--layout", "cicles"],
        ["check", "nothing"],
        ["check", tmp_path / "nothing.h"],
        ["import", tmp_path / "nothing.h", "--output", table],
        ["export-table", "conductor", "--output", tmp_path / "x.h"],
        ["export-table", table, "--output", tmp_path / "x.txt"],
    ):
        code, _, err = call(capsys, *wrong)
        assert (code, err.startswith("error: "), err.count("\n")) == (2, True, 1), wrong


AXES = "--axis r=3 --axis mu=3"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table of ours (t.npz), a file that says what it is (t.h), and two that do not (t.csv, t.npy)."""
    import numpy as np

    from ecfit import Table, write_table

    folder = tmp_path_factory.mktemp("files")
    table = Table.from_array(np.full((3, 3), 0.5), {"r": 3, "mu": 3}, {"model": "conductor"})
    table.save(folder / "t.npz")
    write_table(table, folder / "t.h")
    write_table(table, folder / "t.npy")
    np.savetxt(folder / "t.csv", table.values, delimiter=",")
    return folder


@pytest.mark.parametrize(
    ("command", "words"),
    [
        # How numbers are stored, where the file or its layout says it.
        ("import t.h --stored 1-E --scale 255 --output x.npz", "'t.h' says itself.*leave out stored, scale"),
        ("import t.h --number uint8 --output x.npz", "leave out number"),
        ("check t.h --spacing uniform --order mu,r", "leave out spacing, order"),
        (f"check t.h --layout yocto {AXES} --stored E", "layout 'yocto' says itself.*leave out stored"),
        (f"check t.csv {AXES} --piece front", "pieces are of a layout: leave out piece"),
        (f"import t.npy {AXES} --number uint16 --output x.npz", "leave out number"),
        ("import t.csv --axis r=0,0.5,1 --axis mu=0,0.5,1 --spacing uniform --output x.npz", "out spacing"),
        ("import t.h --piece front --output x.npz", "it is one table: leave piece out"),
        (f"check t.npz {AXES}", "'t.npz' says itself what it is: leave out axis"),
        ("check conductor-10 --layout cycles --scale 255 --channel R", "leave out layout, scale, channel"),
        # A claim without a model, where there is one already.
        ("check t.npz --option masking=separable", "--model unknown.*leave out option"),
        ("check conductor-10 --lobe reflection --transport energy", "leave out lobe, transport"),
        ("check t.h --quantity directional-albedo", "leave out quantity"),
        (f"import t.h --layout yocto {AXES} --exponent 6 --output x.npz", "leave out exponent"),
        # What is of models, of plain axes, of C source or of EXR.
        ("export-table t.npz --quantity schlick-a --lobe all --output x.h", "leave out quantity, lobe"),
        ("export-table conductor-10 --transport energy --layout yocto --output x.h", "leave out transport"),
        ("export-table conductor-10 --option masking=separable --layout yocto --output x.h", "options"),
        ("export-table conductor --layout yocto --spacing gauss --output x.h", "leave out spacing"),
        (f"export-table t.npz {AXES} --output x.h", "a table has its own nodes: leave out axes"),
        (f"import t.csv {AXES} --axis r=4 --output x.npz", "'r' is given 2 times"),
        ("export-table conductor --layout yocto --option a=1 --option a=2 --output x.h", "'a' is given 2"),
        ("export-table t.npz --parts --output x.exr", "leave parts out"),
        ("export-table t.npz --name a --output x.csv", "leave out name"),
    ],
)
def test_nothing_that_is_said_is_silently_ignored(
    capsys: pytest.CaptureFixture[str], files: Path, monkeypatch: pytest.MonkeyPatch, command: str, words: str
):
    monkeypatch.chdir(files)
    code, out, err = call(capsys, *command.split())
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert len(err.splitlines()) == 1
    assert re.search(words, err), err
    assert not list(files.glob("x.*"))


def test_a_claim_on_a_file_without_one_needs_no_model(
    capsys: pytest.CaptureFixture[str], files: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    from ecfit import Table

    monkeypatch.chdir(files)
    claim = ["--quantity", "schlick-b", "--scale", "2", "--output", tmp_path / "b.npz"]
    assert call(capsys, "import", "t.csv", *AXES.split(), *claim)[0] == 0
    made = Table.load(tmp_path / "b.npz")
    assert (made.contract.model, made.contract.quantity) == ("unknown", "schlick-b")
    assert made.values.max() == 0.25


def test_a_plain_axis_is_over_the_range_of_its_model(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    from ecfit import model, read_layout

    given = ["dielectric", "--quantity", "fresnel", "--axis", "ior=3", "--axis", "mu=2"]
    assert call(capsys, "export-table", *given, "--output", tmp_path / "f.csv")[0] == 0
    ends = model("dielectric").parameter_ranges()["ior"]
    axis = read_layout(tmp_path / "f.csv").axes[0]
    assert (axis.low, axis.high) == ends
