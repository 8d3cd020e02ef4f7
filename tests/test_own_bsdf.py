"""From a user's BSDF to GLSL by the commands of docs/add-a-bsdf.md, as they stand there."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from ecfit import cli

ROOT = Path(__file__).parent.parent


@pytest.mark.slow
def test_the_commands_of_the_page_lead_from_a_file_to_a_shader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    page = (ROOT / "docs/add-a-bsdf.md").read_text()
    found = re.search(r"## Into a shader\n.*?```sh\n(.*?)```", page, re.S)
    assert found
    shutil.copy(ROOT / "examples/ward.py", tmp_path)
    monkeypatch.chdir(tmp_path)
    commands = found[1].splitlines()
    assert [shlex.split(command)[1] for command in commands] == [
        "check-bsdf", "table", "fit", "check", "certify", "export",
    ]  # fmt: skip
    for command in commands:
        program, *words = shlex.split(command)
        assert program == "ecfit"
        with pytest.raises(SystemExit) as stop:
            cli.main(words)
        out, err = capsys.readouterr()
        assert (stop.value.code, "WARNING" in out + err) == (0, False), (command, out, err)
    assert "float ward_albedo(float mu, float alpha)" in Path("ward.glsl").read_text()


def test_a_model_that_nobody_registered_is_asked_for_with_a_remedy(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stop:
        cli.main(["check-bsdf", "wart"])
    assert stop.value.code == 2
    assert "unknown model 'wart'" in (err := capsys.readouterr().err)
    assert "--plugin FILE" in err
