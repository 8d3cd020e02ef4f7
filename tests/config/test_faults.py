"""Whatever a study file holds, reading it ends, in a config or in an `EcfitError` with places and keys."""

import re
import tomllib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ecfit.config import StudyConfig, key_lines, read_config, to_toml
from ecfit.errors import EcfitError

GOOD = """\
name = "quick"
plugins = ["mine.py"]
[[tables]]
name = "conductor"
model = "conductor"
options = { masking = "separable", F0 = 0.5 }
quantity = "directional-albedo"
axes = { r = 64, mu = { count = 64, spacing = "uniform" } }
tolerance = 1e-7
[[tables]]
name = "white"
model = "lambertian"
[tables.axes]
mu = [0.0, 0.5, 1.0]
rho.count = 5
rho.low = 0.1
[[fits]]
tables = ["conductor", "white"]
form = "rational"
numerator = 3
denominator = [1, 2]
[[fits]]
tables = ["conductor"]
form = "polynomial"
degree = [1, 2, 3]
[[compare]]
tables = ["conductor"]
published = ["sforza-pellacini-2022-conductor"]
[report]
figures = ["svg", "png"]
"""
# A key whose field has another name.
MODULE = """
[[fits]]
tables = ["white"]
form = "module"
module = "written"
settings = { variables = ["mu"], formula = "1 - a*mu", constants = { a = 0.5 } }
"""

# Values of every type and shape that TOML has, among them arrays in arrays in tables.
VALUES = [
    "1", "-3", "0", "1.5", "nan", "inf", "true", '""', '"x"', '"../x"', "[]", "{}", "[1, 2]", "[[1, 2], [3]]",
    "[[1,\n2],\n[3]]", "{ a = 1 }", "{ a = [[1, 2], [3]] }", "[{ a = [1] }]", "[true]", '["a", "a"]',
    "1979-05-27", "07:32:00", "1e400", "9" * 400, "'''x\n]'''", '"""x [ = { \\""""',
]  # fmt: skip
PIECES = [*"[]{}=,.\"'\n#\\\0\té7", "[[", "]]", '"""', "name"]


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("config") / "study.toml"


def read(path, text: str) -> StudyConfig:
    path.write_text(text, encoding="utf-8")
    return read_config(path)


def fault(path, old: str, new: str) -> str:
    """The message after a change of the good file."""
    assert old in GOOD
    with pytest.raises(EcfitError) as caught:
        read(path, GOOD.replace(old, new, 1))
    return str(caught.value)


def test_the_good_file_is_good(path):
    config = read(path, GOOD)
    assert [t.name for t in config.tables] == ["conductor", "white"]
    assert config.tables[1].axes["rho"].low == 0.1


@pytest.mark.parametrize(
    ("old", "new", "line", "key"),
    [
        ("F0 = 0.5", "F0 = true", 6, "options.F0"),
        ("F0 = 0.5", "F0 = [1]", 6, "options.F0"),
        ("options = {", "options = 3 # {", 6, "tables.options"),
        ("r = 64", "r = [[1, 2], [3]]", 8, "axes.r"),
        ("r = 64", "r = []", 8, "axes.r"),
        ("r = 64", "r = {}", 8, "axes.r"),
        ("r = 64", "r = 1979-05-27", 8, "axes.r"),
        ("1e-7", "0", 9, "tolerance"),
        ("1e-7", "nan", 9, "tolerance"),
        ('"white"', '"conductor"', 11, "name"),
        ('"white"', '"a/b"', 11, "name"),
        ('"white"', '"a\\nb"', 11, "name"),
        ('"white"', '"' + "x" * 81 + '"', 11, "name"),
        ('model = "lambertian"', "", 10, "model"),
        ("[0.0, 0.5, 1.0]", "[0.0, '0.5', 1.0]", 14, "axes.mu"),
        ("[0.0, 0.5, 1.0]", "[0.5]", 14, "axes.mu"),
        ("rho.low = 0.1", "rho.lo = 0.1", 16, "axes.rho.lo"),
        ("rho.low = 0.1", "rho.low = 'a'", 16, "axes.rho.low"),
        ("numerator = 3\n", "", 17, "numerator"),
        ("denominator = [1, 2]", "denominator = [1, 200]", 21, "fits.denominator"),
        ("degree = [1, 2, 3]", "degree = 200", 25, "fits.degree"),
        ("degree = [1, 2, 3]", "degree = true", 25, "fits.degree"),
        ("degree = [1, 2, 3]", "degree = 3.0", 25, "fits.degree"),
        ("degree = [1, 2, 3]", "degree = [[1, 2], [3]]", 25, "fits.degree"),
        ('"sforza-pellacini-2022-conductor"', "", 28, "published"),
        ("[report]", "[reprot]", 29, "reprot"),
        ('"svg"', '"pdf"', 30, "report.figures"),
    ],
)
def test_faults_are_told_with_line_and_key(path, old, new, line, key, no_hang):
    first = fault(path, old, new).splitlines()[0]
    assert first.startswith(f"{path}:{line}: ")
    assert key in first.removeprefix(f"{path}:{line}: ")


def test_a_value_of_the_wrong_type_is_told_once(path):
    """An option may be a word or a number: that is one fault with one place, not one for each type."""
    message = fault(path, "F0 = 0.5", "F0 = true")
    assert len(message.splitlines()) == 1
    assert "options.F0:" in message


@pytest.mark.parametrize(
    "bad", ["", "\n", "# only\n", "name = ", "[[tables", "= 3", "a = [1,", "\ufeffname = 'x'"]
)
def test_a_file_without_toml_is_told(path, bad):
    with pytest.raises(EcfitError, match=re.escape(str(path))):
        read(path, bad)


@settings(max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_value_at_any_key_ends_in_a_config_or_an_error(path, data, no_hang):
    text = GOOD
    for _ in range(data.draw(st.integers(1, 2))):
        places = list(re.finditer(r"= (.*)", text))
        place = data.draw(st.sampled_from(places))
        text = text[: place.start(1)] + data.draw(st.sampled_from(VALUES)) + text[place.end(1) :]
    check(path, text)


@settings(max_examples=400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_damage_ends_in_a_config_or_an_error(path, data, no_hang):
    text = GOOD
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        gone = data.draw(st.integers(0, 5))
        text = text[:at] + data.draw(st.sampled_from(["", *PIECES])) + text[at + gone :]
    check(path, text)


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(order=st.lists(st.sampled_from(GOOD.splitlines()), min_size=1, max_size=40))
def test_any_order_of_lines_ends_in_a_config_or_an_error(path, order, no_hang):
    check(path, "\n".join(order))


def check(path, text: str) -> None:
    try:
        assert isinstance(read(path, text), StudyConfig)
    except EcfitError as error:
        for line in str(error).splitlines():
            assert line.startswith(str(path))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a = 1\nb.c = 2\n", {("a",): 1, ("b",): 2, ("b", "c"): 2}),
        ("[x.y]\nz = 1\n", {("x",): 1, ("x", "y"): 1, ("x", "y", "z"): 2}),
        (
            "[[q]]\n[[q]]\nr = 1\n[q.s]\nt = 2\n",
            {("q", 0): 1, ("q", 1): 2, ("q", 1, "r"): 3, ("q", 1, "s", "t"): 5},
        ),
        ("a = [[1,\n2],\n[3]]\nb = 1\n", {("a", 0, 1): 2, ("a", 1, 0): 3, ("b",): 4}),
        ("a = [1, [2,\n3]]\nb = 1\n", {("a", 1, 1): 2, ("b",): 3}),
        ("a = [{ b = [1] },\n{ b = [[2]] }]\nc = 1\n", {("a", 0, "b"): 1, ("a", 1, "b", 0, 0): 2, ("c",): 3}),
        ("a = '# no comment [' # [\nb = 1\n", {("a",): 1, ("b",): 2}),
        ('a = """\n]\n"""\nb = 1\n', {("a",): 1, ("b",): 4}),
        ("a = '''\n\"\n'''\nb = 1\n", {("a",): 1, ("b",): 4}),
        ('a = "\\"]"\nb = 1\n', {("a",): 1, ("b",): 2}),
        ('\'q"\' = 1\n"d.e" = 2\n"f\\u0041" = 3\n', {('q"',): 1, ("d.e",): 2, ("fA",): 3}),
        ("a = 1\r\nb = 2\r\n", {("a",): 1, ("b",): 2}),
        ("a.1 = 1.5\n3.14 = 1979-05-27T07:32:00.5Z\n", {("a", "1"): 1, ("3", "14"): 2}),
        ("[ a . b ]\nc = 1\n", {("a", "b"): 1, ("a", "b", "c"): 2}),
        ("a = []\nb = {}\n", {("a",): 1, ("b",): 2}),
        ("", {}),
    ],
)
def test_the_line_of_every_key_is_found(text, expected, no_hang):
    tomllib.loads(text)  # the example is valid
    lines = key_lines(text)
    assert {path: lines.get(path) for path in expected} == expected


def paths(data, above=()):
    """The path of every key and array element of parsed TOML."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield (*above, key)
        yield from paths(value, (*above, key))


def test_a_config_has_a_line_for_every_key():
    lines = key_lines(GOOD)
    assert set(paths(tomllib.loads(GOOD))) <= set(lines)
    for path, line in lines.items():
        keys = [part for part in path if isinstance(part, str)]
        if path == tuple(keys) or isinstance(path[-1], str):
            assert keys[-1] in GOOD.splitlines()[line - 1]


@pytest.mark.parametrize(
    "data",
    [
        {"a": "\x7f", "b": '\x00\x1f\u2028\U0001f600"\\\n\t'},
        {"": 1, "a b": {"c.d": [1, 2]}, "\x7f": 3},
        {"a": 1e16, "b": 1e-7, "c": -0.0, "d": 10**30, "e": True},
        {"t": [{"a": 1, "b": {"c": [{"d": 1}]}}, {}], "x": {"y": {}}},
        {"late": {"a": 1}, "plain": 2},
        {"a": [], "b": [[]], "c": [{}]},
        {"a": float("inf"), "b": [float("-inf")]},
    ],
)
def test_written_toml_reads_back(data):
    assert tomllib.loads(to_toml(data)) == data


def test_a_resolved_config_reads_back_as_itself(path):
    """What a study writes beside its results can be run again."""
    config = read(path, GOOD + MODULE)
    assert read(path, to_toml(config.model_dump(exclude_none=True, by_alias=True))) == config
