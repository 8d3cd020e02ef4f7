"""A table as an array in C, with its contract in a comment."""

import re
from collections.abc import Sequence

import numpy as np

from ecfit.errors import EcfitError
from ecfit.tables.numbers import Number

# Literals and C types; halves are bit patterns, as C has no type for them.
_TYPES = {
    "float64": ("double", "{:.17g}"),
    "float32": ("float", "{:.9g}f"),
    "float16": ("unsigned short", "0x{:04x}"),
    "uint16": ("unsigned short", "{}"),
    "uint8": ("unsigned char", "{}"),
}
_IDENTIFIER = re.compile(r"[A-Za-z_]\w*")
_WIDTH = 110


def header_text(rows: np.ndarray, number: Number, name: str, comment: Sequence[str]) -> str:
    """C source of the encoded numbers `rows`, shape (rows, numbers a row).

    Raises `EcfitError` for a name that is no identifier of C.
    """
    if not _IDENTIFIER.fullmatch(name):
        raise EcfitError(f"'{name}' is no name of an array in C: letters, digits and _ only")
    kind, form = _TYPES[number.name]
    shown = rows.view(np.uint16) if number.name == "float16" else rows
    lines = ["/*", *(f" * {text}".rstrip() for text in comment), " */"]
    lines.append(f"static const {kind} {name}[{rows.size}] = {{")
    for row in shown:
        words = [form.format(x) for x in row.tolist()]
        lines += _wrapped([_point(w) for w in words] if kind in ("float", "double") else words)
    return "\n".join([*lines, "};", ""])


def _point(word: str) -> str:
    """A literal of C must have a point or an exponent to be a float: 1f is none."""
    body = word.removesuffix("f")
    plain = body.lstrip("-").isdigit()
    return f"{body}.0{word[len(body) :]}" if plain else word


def _wrapped(words: Sequence[str]) -> list[str]:
    lines, current = [], "   "
    for word in words:
        if len(current) + len(word) + 2 > _WIDTH:
            lines.append(current)
            current = "   "
        current += f" {word},"
    return [*lines, current]
