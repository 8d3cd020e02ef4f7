"""The file of a furnace: what it means, and that each fault is told with its line."""

from pathlib import Path

import pytest

from ecfit.config.furnace import NEEDS, ROLES, read_furnace
from ecfit.errors import EcfitError

ROOT = Path(__file__).parent.parent.parent
GOOD = """\
name = "small"
r = [0.5, 1.0]
[[rows]]
name = "none"
[[rows]]
name = "fit"
conductor = ["conductor-10"]
[[materials]]
name = "white"
model = "conductor"
"""


def told(tmp_path: Path, old: str, new: str) -> str:
    """The message for GOOD with `old` replaced."""
    assert old in GOOD
    path = tmp_path / "furnace.toml"
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(EcfitError) as error:
        read_furnace(path)
    return str(error.value).replace(str(path), "FILE")


@pytest.mark.parametrize("name", ["furnace", "furnace-quick", "studio"])
def test_shipped_files_are_valid(name):
    config = read_furnace(ROOT / "configs" / f"{name}.toml")
    assert config.name == name
    assert {m.model for m in config.materials} == set(NEEDS)
    assert config.rows[0].compensates is False


def test_defaults(tmp_path):
    path = tmp_path / "furnace.toml"
    path.write_text(GOOD)
    config = read_furnace(path)
    assert (config.seeds, config.samples % config.seeds) == (8, 0)
    assert [row.compensates for row in config.rows] == [False, True]
    assert {role for needs in NEEDS.values() for role in needs} == set(ROLES)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("r = [0.5, 1.0]", "r = [0.5, 0.5]", "r has 0.5 twice: a column each"),
        ('name = "fit"', 'name = "a | b"', "FILE:6: rows.name"),
        ('"conductor"\n', '"conductor"\neta = [1.0, 1.0, inf]\nk = [1.0, 1.0, 1.0]\n', "finite number"),
        ("r = [0.5, 1.0]", "r = [0.5, 1.5]", "FILE:2: r: 1.5: should be less than or equal to 1"),
        ("conductor =", "conductr =", "FILE:7: rows.conductr: unknown key"),
        ('"conductor"', '"metal"', "FILE:10: materials.model: 'metal': expected one of conductor, glossy"),
        (
            '"conductor"',
            '"glossy"\nior = [1.5]',
            "FILE:5: rows: the row 'fit' has no glossy, which the material",
        ),
        ('"conductor"\n', '"conductor"\nior = [1.5]\n', "give ior, but not for a conductor"),
        ('"conductor"\n', '"dielectric"\n', "give ior, but not for a conductor"),
        ('"conductor"\n', '"conductor"\neta = [1.0, 1.0, 1.0]\n', "eta and k go together"),
        ('"conductor"\n', '"conductor"\nrho = [1.0, 1.0, 1.0]\n', "rho belongs to the model 'glossy'"),
        ('name = "fit"', 'name = "none"', "FILE:6: rows.name: the name 'none' is used twice"),
        (
            "[[materials]]",
            '[[materials]]\nname = "white"\nmodel = "conductor"\n[[materials]]',
            "FILE:12: materials.name: two materials make the picture 'white'",
        ),
        ("conductor = [", "table = 32\nconductor = [", "give either table or names of fits"),
        (
            'name = "small"',
            'name = "small"\nsamples = 100',
            "samples must be a multiple of seeds, 8: got 100",
        ),
        ('name = "small"', 'name = "../small"', "FILE:1: name: '../small': expected a plain word"),
    ],
)
def test_faults_are_told_with_their_line(tmp_path, old, new, message):
    assert message in told(tmp_path, old, new)


def test_an_empty_file_points_to_an_example(tmp_path):
    path = tmp_path / "furnace.toml"
    path.write_text("")
    with pytest.raises(EcfitError, match=r"configs/furnace\.toml"):
        read_furnace(path)
