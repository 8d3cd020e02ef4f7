"""What a study file may say, and how a fault in one is told."""

import random
from pathlib import Path
from typing import get_args

import pytest

import ecfit.config
from ecfit.config import CHOICES, StudyConfig, read_config
from ecfit.config.furnace import read_furnace
from ecfit.errors import EcfitError

ROOT = Path(__file__).parent.parent.parent

GOOD = """name = "q"
[[tables]]
name = "c"
model = "conductor"
options = { masking = "separable" }
axes = { r = 8, mu = { count = 8, spacing = "gauss" } }
[[fits]]
tables = ["c"]
form = "rational"
degree = [1, 2]
[[fits]]
tables = ["c"]
form = "rational"
numerator = [2, 3]
denominator = 1
"""


def read(tmp_path: Path, text: str) -> StudyConfig:
    path = tmp_path / "study.toml"
    path.write_text(text)
    return read_config(path)


@pytest.mark.parametrize(
    "path", [*sorted((ROOT / "configs").glob("*.toml")), *sorted((ROOT / "examples").glob("*.toml"))]
)
def test_shipped_configs_are_valid(path: Path):
    if "[[materials]]" in path.read_text():
        assert read_furnace(path).materials
    else:
        assert read_config(path).tables


def test_short_forms_stand_for_long_ones(tmp_path: Path):
    config = read(tmp_path, GOOD)
    assert config.tables[0].axes["r"].count == 8
    assert config.tables[0].axes["r"].spacing == "uniform"
    assert config.fits[0].settings() == [{"degree": 1}, {"degree": 2}]
    assert config.fits[1].settings() == [
        {"numerator": 2, "denominator": 1},
        {"numerator": 3, "denominator": 1},
    ]
    nodes = read(tmp_path, GOOD.replace("r = 8", "r = [0.1, 0.5]")).tables[0].axes["r"].nodes
    assert nodes == [0.1, 0.5]


def test_a_rational_may_be_left_unguarded(tmp_path: Path):
    config = read(tmp_path, GOOD.replace("degree = [1, 2]", "degree = [1, 2]\nguarded = false"))
    assert config.fits[0].settings() == [{"degree": 1, "guarded": False}, {"degree": 2, "guarded": False}]
    apart = read(tmp_path, GOOD.replace("denominator = 1", "denominator = 1\nguarded = false"))
    assert apart.fits[1].settings()[0] == {"numerator": 2, "denominator": 1, "guarded": False}


FILE = """name = "q"
[[tables]]
name = "theirs"
file = "theirs.exr"
stored = "1-E"
scale = 65535
order = ["-mu", "r"]
channel = "G"
axes = { r = 32, mu = { count = 32, spacing = "texel-centre" } }
"""


def test_a_table_may_be_a_file(tmp_path: Path):
    table = read(tmp_path, FILE).tables[0]
    assert (table.model, table.file, table.stored, table.channel) == ("unknown", "theirs.exr", "1-E", "G")
    assert table.tolerance is None
    plain = read(tmp_path, FILE.replace('stored = "1-E"\nscale = 65535\n', "")).tables[0]
    assert (plain.stored, plain.scale) == ("E", 1.0)
    integrated = read(tmp_path, GOOD).tables[0]
    assert (integrated.tolerance, integrated.stored, integrated.scale) == (1e-7, None, None)


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (("axes", "tolerance = 1e-6\naxes"), 2, ("tolerance belongs to what is integrated",)),
        (('file = "theirs.exr"', 'model = "conductor"'), 2, ("stored says how a file is read", "give file")),
        (('file = "theirs.exr"\n', ""), 2, ("model", "missing")),
        (('file = "theirs.exr"', 'file = ""'), 4, ("file", "at least 1")),
        (('file = "theirs.exr"', "file = 3"), 4, ("file", "string")),
        (('"1-E"', '"1 - E"'), 5, ("stored", "E, 1-E")),
        (("65535", "0"), 6, ("scale", "greater than 0")),
        (("65535", "nan"), 6, ("scale",)),
        (('["-mu", "r"]', '"mu, r"'), 7, ("order", "list")),
        (('["-mu", "r"]', "[1, 2]"), 7, ("order", "string")),
        (('"G"', "1"), 8, ("channel", "string")),
        (("order", "ordre"), 7, ("ordre", "did you mean 'order'")),
        (("texel-centre", "texel-center"), 9, ("did you mean 'texel-centre'",)),
    ],
)
def test_a_fault_in_a_table_of_a_file_is_told(tmp_path: Path, change, line: int, words):
    assert change[0] in FILE
    with pytest.raises(EcfitError) as caught:
        read(tmp_path, FILE.replace(*change, 1))
    first = str(caught.value).splitlines()[0]
    assert first.startswith(f"{tmp_path / 'study.toml'}:{line}: "), first
    for word in words:
        assert word in first


def test_a_quantity_may_have_options(tmp_path: Path):
    text = 'quantity = "schlick-b"\nquantity_options = { exponent = 6 }\naxes'
    assert read(tmp_path, GOOD.replace("axes", text, 1)).tables[0].quantity_options == {"exponent": 6}
    assert read(tmp_path, GOOD).tables[0].quantity_options == {}


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (('name = "q"', 'nmae = "q"'), 1, ("nmae", "unknown key", "did you mean 'name'")),
        (('name = "q"', 'name = "../../q"'), 1, ("name", "plain word")),
        (('name = "q"', 'name = ".hidden"'), 1, ("name", "plain word")),
        (('name = "q"', "name = 3"), 1, ("name", "3")),
        (("model = ", "modle = "), 4, ("modle", "did you mean 'model'")),
        (('spacing = "gauss"', 'spacing = "gaus"'), 6, ("spacing", "uniform", "did you mean 'gauss'")),
        (("r = 8", "r = 1"), 6, ("axes.r", "greater than or equal to 2")),
        (("r = 8", "r = 1e400"), 6, ("axes.r", "a count, a list of nodes")),
        (("r = 8", 'r = "8"'), 6, ("axes.r", "a count, a list of nodes")),
        (("r = 8", "r = true"), 6, ("axes.r", "a count, a list of nodes")),
        (("count = 8,", "count = 8, nodes = [1.0, 2.0],"), 6, ("axes.mu", "either count or nodes")),
        (("degree = [1, 2]", "degree = 0"), 7, ("fits", "1 or more")),
        (("degree = [1, 2]", "degree = [1, 200]"), 10, ("fits.degree", "less than or equal to 20")),
        (("degree = [1, 2]", "degree = []"), 10, ("fits.degree", "at least 1")),
        (("degree = [1, 2]", 'degree = "3"'), 10, ("fits.degree", "list")),
        (("degree = [1, 2]\n", ""), 7, ("fits", "either degree, or both")),
        (('form = "rational"', 'form = "ratoinal"'), 9, ("polynomial, rational", "did you mean 'rational'")),
        (("degree = [1, 2]", "degree = 1\nguarded = 1"), 11, ("guarded", "boolean")),
        (('form = "rational"', 'form = "polynomial"\nguarded = false'), 7, ("fits", "not belong to")),
        (("axes", "quantity_options = { exponent = 1.5 }\naxes"), 6, ("exponent", "integer")),
        (("axes", "quantity_option = {}\naxes"), 6, ("did you mean 'quantity_options'",)),
        (('tables = ["c"]', 'tables = ["d"]'), 8, ("no table 'd'", "c")),
        (("denominator = 1", 'denominator = 1\nextra = "x"'), 16, ("extra", "unknown key")),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_file_line_key_and_remedy(tmp_path: Path, change, line: int, words):
    assert change[0] in GOOD
    with pytest.raises(EcfitError) as caught:
        read(tmp_path, GOOD.replace(*change, 1))
    first = str(caught.value).splitlines()[0]
    assert first.startswith(f"{tmp_path / 'study.toml'}:{line}: "), first
    for word in words:
        assert word in first


def test_all_faults_are_told_at_once(tmp_path: Path):
    text = GOOD.replace("model = ", "modle = ").replace("degree = [1, 2]", "degree = 99")
    with pytest.raises(EcfitError) as caught:
        read(tmp_path, text)
    assert len(str(caught.value).splitlines()) == 3  # an unknown key, the missing one, the degree


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file is empty"),
        ("# nothing\n", "the file is empty"),
        ("name = ", "not valid TOML"),
        ("x = " + "[" * 5000, "not valid TOML"),
        ('name = "q"\n', "tables: this key is missing"),
        (GOOD + GOOD.split("[[fits]]")[0].split("\n", 1)[1], "'c' is used twice"),
    ],
)
def test_broken_files_are_told(tmp_path: Path, text: str, words: str):
    with pytest.raises(EcfitError, match=words):
        read(tmp_path, text)


def test_a_file_that_is_not_text_is_told(tmp_path: Path):
    (tmp_path / "study.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(EcfitError, match="not a text file"):
        read_config(tmp_path / "study.toml")
    with pytest.raises(EcfitError, match="cannot read"):
        read_config(tmp_path)


def test_no_mutation_of_a_config_gives_anything_but_a_config_or_an_error(tmp_path: Path):
    rng = random.Random(0)
    pieces = [
        "[",
        "]",
        "{",
        "}",
        "=",
        '"',
        "\n",
        ",",
        ".",
        "#",
        "-1",
        "1e99",
        "true",
        "''",
        "nan",
        "name",
        "\\",
        "é",
    ]
    accepted = 0
    for _ in range(1500):
        text = GOOD
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(text))
            text = text[:at] + rng.choice([*pieces, ""]) + text[at + rng.randint(0, 4) :]
        try:
            accepted += isinstance(read(tmp_path, text), StudyConfig)
        except EcfitError as error:
            message = str(error)
        else:
            continue
        assert message.startswith(str(tmp_path / "study.toml"))
    assert 0 < accepted < 1500


@pytest.mark.parametrize(("section", "field"), list(CHOICES))
def test_the_allowed_words_are_those_of_the_code(section: str, field: str):
    annotation = getattr(ecfit.config, section).model_fields[field].annotation
    assert set(get_args(annotation)) == CHOICES[section, field]


STRUCTURED = """name = "q"
[[tables]]
name = "c"
model = "conductor"
axes = { r = 8, mu = 8 }
[[fits]]
tables = ["c"]
form = "structured"
head = "corner"
features = ["alpha", "mu"]
terms = { numerators = [[[1.0, 0.0]]], denominator = [[3.0, 0.0], [0.0, 3.0]] }
norm = "l1"
[[fits]]
tables = ["c"]
form = "selected"
head = "corner"
features = ["alpha", "mu"]
within.numerators = [{ highest = { alpha = 2.0 } }]
within.denominator = { highest = { mu = 3.0 }, step = 0.5 }
budget = [3, 4]
"""


def test_structured_and_selected_forms_have_their_settings(tmp_path: Path):
    given, chosen = read(tmp_path, STRUCTURED).fits
    (settings,) = given.settings()
    assert settings["numerators"] == [[[1.0, 0.0]]]
    assert settings["denominator"] == [[3.0, 0.0], [0.0, 3.0]]
    assert given.norm_settings() == {"norm": "l1"}
    assert [s["budget"] for s in chosen.settings()] == [3, 4]
    assert chosen.settings()[0]["denominator"]["step"] == 0.5
    assert chosen.norm_settings() == {}
    own = STRUCTURED.replace('"corner"', '{ name = "x", factors = [{}], text = "X" }', 1)
    assert read(tmp_path, own).fits[0].settings()[0]["head"]["text"] == "X"


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (('norm = "l1"', 'norm = "l2"'), 12, ("norm", "'l2'", "least-squares, l1, l3, l4")),
        (('norm = "l1"', "digits = 2"), 12, ("digits", "greater than or equal to 3")),
        (('norm = "l1"', "strength = -1.0"), 12, ("strength", "greater than or equal to 0")),
        (('norm = "l1"', "ridge = true"), 12, ("ridge", "number")),
        (('norm = "l1"', "degree = 2"), 6, ("degree does not belong to the form 'structured'",)),
        (('norm = "l1"', "budget = 3"), 6, ("budget does not belong to the form 'structured'",)),
        (("budget = [3, 4]", "start = [1.0]\nbudget = 3"), 13, ("start does not belong", "'selected'")),
        (("budget = [3, 4]", ""), 13, ("the form 'selected' needs budget",)),
        (("budget = [3, 4]", "budget = 1"), 20, ("budget", "greater than or equal to 2")),
        (("budget = [3, 4]", "budget = [3, 4]\nname = 'x'"), 13, ("a name is for one fit",)),
        (("budget = [3, 4]", "budget = 3\nseeds = 0"), 21, ("seeds", "greater than or equal to 1")),
        (("step = 0.5", "step = 0.0"), 19, ("step", "greater than 0")),
        (("step = 0.5", "stp = 0.5"), 19, ("unknown key", "did you mean 'step'")),
        (('head = "corner"\n', ""), 6, ("the form 'structured' needs head",)),
        (("[3.0, 0.0]", "3.0"), 11, ("denominator", "list")),
        (('form = "structured"', 'form = "polynomial"\ndegree = 1'), 6, ("does not belong", "'polynomial'")),
    ],
)
def test_a_fault_in_a_structured_form_is_told(tmp_path: Path, change, line: int, words):
    assert change[0] in STRUCTURED
    with pytest.raises(EcfitError) as caught:
        read(tmp_path, STRUCTURED.replace(*change, 1))
    first = str(caught.value).splitlines()[0]
    assert first.startswith(f"{tmp_path / 'study.toml'}:{line}: "), first
    for word in words:
        assert word in first
