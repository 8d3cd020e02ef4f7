"""Where each key of a TOML text stands, for error messages; and TOML written from plain data."""

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

Path = tuple[str | int, ...]

# One token of TOML: what can hide brackets and equals signs (strings, comments) comes first.
_TOKEN = re.compile(
    r'(?P<string>"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\')'
    r"|(?P<comment>#[^\n]*)|(?P<newline>\n)|(?P<mark>[\[\]{},=.])|(?P<bare>[^\s\[\]{},=.#\"']+)",
    re.DOTALL,
)


def _tokens(text: str) -> Iterator[tuple[str, str, int]]:
    line = 1
    for match in _TOKEN.finditer(text):
        kind, value = match.lastgroup or "", match.group()
        yield kind, value, line
        line += value.count("\n")


def _unquoted(kind: str, value: str) -> str:
    return tomllib.loads(f"key = {value}")["key"] if kind == "string" else value


class _Locator:
    """Walks the tokens of a valid TOML text and notes the line of every key."""

    def __init__(self, text: str) -> None:
        self.tokens = [t for t in _tokens(text) if t[0] != "comment"]
        self.at = 0
        self.lines: dict[Path, int] = {}
        self.arrays: dict[Path, int] = {}

    def peek(self) -> str:
        return self.tokens[self.at][1] if self.at < len(self.tokens) else ""

    def take(self) -> tuple[str, str, int]:
        token = self.tokens[self.at]
        self.at += 1
        return token

    def key(self) -> tuple[list[str], int]:
        parts, line = [], self.tokens[self.at][2]
        while self.peek() not in ("=", "]", ""):
            kind, value, _ = self.take()
            if value != ".":
                parts.append(_unquoted(kind, value))
        return parts, line

    def note(self, path: Path, line: int) -> None:
        for depth in range(1, len(path) + 1):
            self.lines.setdefault(path[:depth], line)

    def header(self) -> Path:
        self.take()
        array = self.peek() == "["
        if array:
            self.take()
        parts, line = self.key()
        for _ in range(1 + array):
            self.take()
        path: Path = ()
        for i, part in enumerate(parts):
            path = (*path, part)
            if array and i == len(parts) - 1:
                self.arrays[path] = self.arrays.get(path, -1) + 1
            if path in self.arrays:
                path = (*path, self.arrays[path])
        self.note(path, line)
        return path

    def value(self, path: Path) -> None:
        opening = self.take()[1]
        if opening == "[":
            index = 0
            while self.peek() != "]":
                if self.peek() in (",", "\n"):
                    index += self.take()[1] == ","
                else:
                    self.note((*path, index), self.tokens[self.at][2])
                    self.value((*path, index))
            self.take()
        elif opening == "{":
            while self.peek() != "}":
                if self.peek() in (",", "\n"):
                    self.take()
                else:
                    self.pair(path)
            self.take()
        else:
            while self.peek() not in (",", "\n", "]", "}", ""):
                self.take()

    def pair(self, table: Path) -> None:
        parts, line = self.key()
        self.take()  # the equals sign
        path = (*table, *parts)
        self.note(path, line)
        self.value(path)

    def run(self) -> dict[Path, int]:
        table: Path = ()
        while self.at < len(self.tokens):
            token = self.peek()
            if token == "\n":
                self.take()
            elif token == "[":
                table = self.header()
            else:
                self.pair(table)
        return self.lines


def deepest_key(text: str) -> int:
    """Most parts that a dotted key of any text has (or what looks like one): readers take their square."""
    most = parts = 0
    word = False
    for kind, value, _ in _tokens(text):
        named = kind in ("bare", "string")
        parts = parts + 1 if named and not word else parts if value == "." else 0
        word = named
        most = max(most, parts)
    return most


def key_lines(text: str) -> dict[Path, int]:
    """Path of each key of a valid TOML text -> its line, counted from 1; array elements by index."""
    try:
        return _Locator(text).run()
    except IndexError:  # a construct that this walk does not know: messages then lack the line
        return {}


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)  # inf, -inf and nan: TOML's words and Python's, but not JSON's
    return _quoted(value)


def _quoted(value: str | float) -> str:
    """JSON writes strings and numbers as TOML does, but for the one control character that it leaves."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _quoted(key)


def to_toml(data: Mapping[str, Any]) -> str:
    """TOML text of plain data: lists of mappings become arrays of tables, mappings become tables."""
    plain, tables = [], []
    for key, value in data.items():
        if isinstance(value, list) and value and all(isinstance(v, Mapping) for v in value):
            for item in value:
                tables.append(f"\n[[{_key(key)}]]")
                tables += [f"{_key(k)} = {_value(v)}" for k, v in item.items()]
        elif isinstance(value, Mapping):
            tables.append(f"\n[{_key(key)}]")
            tables += [f"{_key(k)} = {_value(v)}" for k, v in value.items()]
        else:
            plain.append(f"{_key(key)} = {_value(value)}")
    return "\n".join([*plain, *tables]) + "\n"
