"""Numbers from C source: the list between the braces of an array. Nothing is compiled or executed."""

import re
from pathlib import Path

import numpy as np

from ecfit.errors import EcfitError
from ecfit.files import read_text
from ecfit.tables.interleaved import CHANNELS, picked

# Larger than any table of albedos that anybody compiles: Cycles keeps all of its in 1.5 MB.
_MOST_BYTES = 64 << 20
# Of a half: 16 bits.
_MOST_BITS = 65535
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_ARRAY = re.compile(r"([A-Za-z_]\w*)\s*((?:\[[^\]\n]*\]\s*)+)=\s*(?=\{)")
_LIST = re.compile(r"(?:new\s+\w+\s*\(\s*)?\[\s*(?=[-+.\d])")
_NUMBER = re.compile(r"[-+]?(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
# What may stand around the numbers: separators, nested braces, suffixes of literals.
_REST = re.compile(r"[\s,{}fFuUlL]*")


def read_header(path: Path, count: int, channel: str | None, kind: str | None) -> np.ndarray:
    """`count` numbers of an array in C (or a list in JavaScript), one dimension.

    `channel`: the array's name where there are several, one of interleaved channels (R, 0), or both
    ("table.R"). `kind`: "float16" where the numbers are bit patterns of halves. Raises `EcfitError` for
    anything but numbers between the braces.
    """
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise EcfitError(f"'{path}' has {size} bytes: too many for a table in source code")
    text = _COMMENT.sub(" ", read_text(path))
    wanted, _, within = (channel or "").partition(".")
    if channel is not None and not within and (channel in CHANNELS or channel.isdecimal()):
        wanted, within = "", channel
    arrays = {m.group(1): m.end() for m in _ARRAY.finditer(text)}
    if not arrays and (plain := _LIST.search(text)):
        arrays = {"": text.index("[", plain.start())}
    if not arrays:
        body = text if _REST.fullmatch(_NUMBER.sub("", text)) else ""
        if not body.strip():
            raise EcfitError(f"'{path}' has no array of numbers: expected name[N] = {{ ... }}")
        arrays, text = {"": 0}, "{" + body + "}"
    if wanted:
        if wanted not in arrays:
            raise EcfitError(f"'{path}' has no array '{wanted}': expected one of {', '.join(arrays)}")
        start = arrays[wanted]
    elif len(arrays) == 1:
        start = next(iter(arrays.values()))
    else:
        raise EcfitError(f"'{path}' has several arrays: name one as the channel: {', '.join(arrays)}")
    flat = _numbers(path, _body(path, text, start))
    if kind == "float16" and flat.size and np.all(flat == np.rint(flat)) and flat.min() >= 0:
        if flat.max() > _MOST_BITS:
            raise EcfitError(
                f"'{path}' has {flat.max():.6g} among the bits of halves: they end at {_MOST_BITS}"
            )
        flat = flat.astype(np.uint16).view(np.float16).astype(np.float64)
    return picked(flat, count, within or None, f"'{path}'")


def _body(path: Path, text: str, start: int) -> str:
    """What stands between a bracket and its partner."""
    opening = text[start]
    closing = {"{": "}", "[": "]"}[opening]
    depth = 0
    for match in re.compile(f"[{re.escape(opening + closing)}]").finditer(text, start):
        depth += 1 if match.group() == opening else -1
        if depth == 0:
            return text[start + 1 : match.start()]
    raise EcfitError(f"'{path}' ends within an array")


def _numbers(path: Path, body: str) -> np.ndarray:
    rest = _NUMBER.sub("", body)
    if not _REST.fullmatch(rest):
        odd = re.sub(_REST, "", rest)[:20]
        raise EcfitError(f"'{path}' has other things than numbers in its array: '{odd}'")
    words = _NUMBER.findall(body)
    try:
        return np.array([float(int(w, 16)) if "x" in w.lower() else float(w) for w in words])
    except (ValueError, OverflowError):
        raise EcfitError(f"'{path}' has numbers that cannot be read") from None
