"""`ecfit export`: to a file or to the terminal, from names, fits' files and tables; mistakes are one line."""

import pytest

from ecfit.approximation import find
from ecfit.cli import main
from ecfit.export import code
from ecfit.files import write_json


def run(*arguments: str) -> None:
    """The command, which ends with exit code 0."""
    with pytest.raises(SystemExit) as stopped:
        main(["export", *arguments])
    assert stopped.value.code == 0


def test_printed_and_written_are_the_same(tmp_path, capsys):
    run("conductor-7", "--lang", "hlsl", "--coordinates", "r", "--factor", "--derivative", "mu")
    printed = capsys.readouterr().out
    expected = code(find("conductor-7"), "hlsl", coordinates=("r",), factor=True, derivative="mu")
    assert printed == expected
    path = tmp_path / "sub" / "E.hlsl"
    run("conductor-7", "--lang", "hlsl", "--name", "E", "--output", str(path))
    assert path.read_text() == code(find("conductor-7"), "hlsl", name="E")
    assert str(path) in capsys.readouterr().out


def test_a_file_of_a_fit(tmp_path, capsys):
    write_json(tmp_path / "mine.json", find("conductor-7").to_dict())
    run(str(tmp_path / "mine.json"), "--lang", "wgsl")
    out = capsys.readouterr().out
    assert "fn conductor_7(mu: f32, alpha: f32) -> f32 {" in out
    assert "not measured here" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["conductor-7", "--lang", "glsls"], "expected one of c, cpp, glsl, hlsl, materialx, msl, osl"),
        (["conductor-7", "--lang", "wgsl", "--name", "fn"], "'fn' is reserved in WGSL"),
        (["conductor-8", "--lang", "c"], "unknown shipped or published fit"),
        (
            ["conductor-7", "--lang", "c", "--coordinates", "r,alpha"],
            "'r' and 'alpha' are two views of one coordinate",
        ),
        (["conductor-7", "--lang", "materialx"], "say --output FOLDER"),
        (["missing.json", "--lang", "c"], "no such file"),
    ],
)
def test_mistakes_are_one_line(arguments, message, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["export", *arguments])
    assert stopped.value.code == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.splitlines()) == 1
