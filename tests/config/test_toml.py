"""Lines of keys in TOML, and TOML from plain data."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecfit.config import key_lines, to_toml
from ecfit.config.toml import deepest_key

TEXT = '''# [[not]] = "a header"
name = "a = [b] # c"
axes.r = { count = 4, spacing = "uniform" } # }


[[tables]]
name = "one"   # a comment with ] and =
nodes = [
  1.0,  # [
  2.0,
]
[tables.options]
"quoted key" = """
several = lines
"""
[[tables]]
axes = { mu = [0.5, 1.0], r.low = 0.0 }
nested = [[1, 2], [3]]

[report]
figures = []
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("name",), 2),
        (("axes", "r"), 3),
        (("axes", "r", "spacing"), 3),
        (("tables", 0, "name"), 7),
        (("tables", 0, "nodes", 1), 10),
        (("tables", 0, "options", "quoted key"), 13),
        (("tables", 1), 16),
        (("tables", 1, "axes", "mu", 1), 17),
        (("tables", 1, "axes", "r", "low"), 17),
        (("tables", 1, "nested", 1, 0), 18),
        (("report", "figures"), 21),
    ],
)
def test_the_line_of_every_key_is_found(path: tuple, line: int):
    tomllib.loads(TEXT)  # the example is valid
    assert key_lines(TEXT)[path] == line


plain = st.recursive(
    st.booleans() | st.integers(-(2**60), 2**60) | st.floats(-1e300, 1e300) | st.text(),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(), inner, max_size=3)),
    max_leaves=8,
)  # fmt: skip


@given(st.dictionaries(st.text(), plain, max_size=4))
def test_written_toml_reads_back(data: dict):
    assert tomllib.loads(to_toml(data)) == data


@given(st.dictionaries(st.text("ab.", min_size=1), plain, min_size=1, max_size=4))
def test_every_top_level_key_has_a_line(data: dict):
    lines = key_lines(to_toml(data))
    for key in data:
        assert (key,) in lines


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("", 0),
        ("a = 1", 1),
        ('a."b.c" . d = 1', 3),
        ("[a.b]\nc = [0.5, 0.25]", 2),
        ("a = '1.2.3.4.5' # x.y.z", 1),
        ("x = { a.b.c.d = 1 }", 4),
        ("..a..b", 2),
    ],
)
def test_parts_of_the_deepest_key(text: str, parts: int):
    assert deepest_key(text) == parts
