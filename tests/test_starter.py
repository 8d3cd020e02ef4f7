"""`ecfit init`: a study to start from, which is valid, runs, and never overwrites."""

from pathlib import Path

import pytest

from ecfit.config import read_config
from ecfit.config.furnace import read_furnace
from ecfit.errors import EcfitError
from ecfit.starter import command_for, configs, write_config
from ecfit.study.plan import make_plan

ROOT = Path(__file__).parent.parent


def test_the_starter_is_a_study_named_after_its_file(tmp_path: Path):
    path = write_config(tmp_path / "my-study.toml")
    plan = make_plan(read_config(path), tmp_path)
    assert plan.config.name == "my-study"
    assert {f.form.name if hasattr(f.form, "name") else "" for f in plan.fits}
    assert plan.compare["metal"]


def test_every_study_of_the_repository_comes_with_it(tmp_path: Path):
    found = configs()
    assert set(found) == {"starter", *(p.stem for p in (ROOT / "configs").glob("*.toml"))}
    for name in found:
        path = write_config(tmp_path / f"x-{name}.toml", like=name)
        config = {"furnace": read_furnace, "run": read_config}[command_for(path)](path)
        assert config.name == f"x-{name}"


def test_what_is_commented_out_in_the_starter_is_valid_too(tmp_path: Path):
    """The second table: whoever removes the marks gets a study."""
    text = configs()["starter"].read_text()
    start = text.index("# [[tables]]\n")
    end = text.index("\n\n", start)
    table = "\n".join(line.removeprefix("# ") for line in text[start:end].splitlines())
    path = tmp_path / "s.toml"
    path.write_text(text[:start] + table + text[end:])
    assert [t.name for t in read_config(path).tables] == ["metal", "glass"]


def test_nothing_is_overwritten(tmp_path: Path):
    path = tmp_path / "mine.toml"
    path.write_text("precious")
    with pytest.raises(EcfitError, match="exists"):
        write_config(path)
    assert path.read_text() == "precious"
    link = tmp_path / "link.toml"
    link.symlink_to(tmp_path / "nowhere.toml")
    with pytest.raises(EcfitError, match="exists"):
        write_config(link)


@pytest.mark.parametrize(
    ("name", "like", "message"),
    [
        ("study", "starter", "ends in .toml"),
        ("a b.toml", "starter", "cannot name a study"),
        ("-x.toml", "starter", "cannot name a study"),
        ("x.toml", "quik", "did you mean 'quick'"),
    ],
)
def test_bad_names_are_refused(tmp_path: Path, name: str, like: str, message: str):
    with pytest.raises(EcfitError, match=message):
        write_config(tmp_path / name, like)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_starter_runs(tmp_path: Path):
    import ecfit

    study = ecfit.run(write_config(tmp_path / "start.toml"), tmp_path / "results", workers=1)
    assert study.warnings() == []
    assert study.report.exists()
