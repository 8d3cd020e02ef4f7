"""Numbers from text: a matrix, a list, or one line an entry with its coordinates under a header."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ecfit.coordinates import Axis
from ecfit.errors import EcfitError, did_you_mean
from ecfit.files import read_text
from ecfit.tables.layout import arranged

# Room for a number with its separator (17 digits, sign, exponent) and for comments: what is larger is no
# table of that many entries, and is not read.
_BYTES_A_NUMBER = 40
_BYTES_BESIDE = 1 << 20
# A coordinate may be off its node by this part of the smallest step: it was printed with few digits.
_OFF_NODE = 0.02


def read_csv(
    path: Path, axes: Sequence[Axis], order: Sequence[str] | None, channel: str | None
) -> np.ndarray:
    """The values, one dimension an axis, in the order of `axes`.

    Cells are separated by tabs, semicolons, commas or spaces; `#` begins a comment. Without a header the file
    is a matrix or a list, in the given `order`. With one, each line is an entry: its columns are the axes and
    `value` (or the name given as `channel`), in any order of lines. Raises `EcfitError` for anything else.
    """
    lines = _lines(path, axes)
    header = lines[0][1]
    if any(_number(cell) is None for cell in header):
        if order is not None:
            raise EcfitError(f"'{path}' names the coordinates of its values: leave order out")
        return _long(path, axes, header, lines[1:], channel or "value")
    if channel is not None:
        raise EcfitError(f"'{path}' has no header line, so no channel '{channel}': leave channel out")
    rows = [_numbers(path, line, cells) for line, cells in lines]
    count = int(np.prod([len(a) for a in axes]))
    widths = {len(row) for row in rows}
    last = _last_count(axes, order)
    flat = np.array([x for row in rows for x in row])
    # Lines of a list are often wrapped: at any width with a shorter last line, or within a row of the table.
    wrapped = len(widths) > 1 and flat.size == count
    if wrapped or (len(widths) == 1 and last > max(widths) and last % max(widths) == 0):
        return arranged(flat, axes, order, f"'{path}'")
    if len(widths) > 1:
        line = next(line for (line, _), row in zip(lines, rows, strict=True) if len(row) != len(rows[0]))
        raise EcfitError(
            f"{path}:{line}: not as many numbers as in the lines before, and {flat.size} in all, "
            f"expected {count}"
        )
    return arranged(flat.reshape(len(rows), -1), axes, order, f"'{path}'")


def _last_count(axes: Sequence[Axis], order: Sequence[str] | None) -> int:
    """Length of the axis that varies fastest (a wrong order is told elsewhere)."""
    name = axes[-1].name if not order else str(order[-1]).removeprefix("-")
    return next((len(a) for a in axes if a.name == name), 0)


def _lines(path: Path, axes: Sequence[Axis]) -> list[tuple[int, list[str]]]:
    """(line number, cells) of every line that holds any."""
    count = int(np.prod([len(a) for a in axes]))
    most = _BYTES_BESIDE + _BYTES_A_NUMBER * count * (len(axes) + 4)
    size = path.stat().st_size
    if size > most:
        raise EcfitError(
            f"'{path}' has {size} bytes, more than {count} entries take: check the counts of the axes"
        )
    lines = []
    separator: str | None = None
    for number, text in enumerate(read_text(path).removeprefix("\ufeff").splitlines(), start=1):
        line = text.partition("#")[0].strip()
        if not line:
            continue
        if not lines:
            separator = next((s for s in "\t;," if s in line), None)
        cells = [cell.strip().strip('"') for cell in line.split(separator)]
        lines.append((number, cells[:-1] if len(cells) > 1 and not cells[-1] else cells))
    if not lines:
        raise EcfitError(f"'{path}' is empty")
    return lines


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _numbers(path: Path, line: int, cells: list[str]) -> list[float]:
    row = []
    for cell in cells:
        value = _number(cell)
        if value is None:
            raise EcfitError(f"{path}:{line}: '{cell[:40]}' is not a number")
        row.append(value)
    return row


def _long(
    path: Path,
    axes: Sequence[Axis],
    header: list[str],
    lines: list[tuple[int, list[str]]],
    value: str,
) -> np.ndarray:
    wanted = [*(a.name for a in axes), value]
    for name in wanted:
        if header.count(name) != 1:
            found = "twice" if name in header else "not"
            raise EcfitError(
                f"{path}: the column '{name}' is {found} in the header: expected {', '.join(wanted)}"
                + ("" if name in header else did_you_mean(name, header))
            )
    for line, cells in lines:
        if len(cells) != len(header):
            raise EcfitError(f"{path}:{line}: {len(cells)} cells, the header has {len(header)}")
    columns = [header.index(name) for name in wanted]
    rows = [_numbers(path, line, [cells[c] for c in columns]) for line, cells in lines]
    data = np.array(rows, dtype=np.float64).reshape(len(rows), len(columns))
    index = []
    for axis, x in zip(axes, data.T, strict=False):
        nodes = axis.nominal
        after = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
        near = np.where(x - nodes[after - 1] <= nodes[after] - x, after - 1, after)
        off = ~(np.abs(x - nodes[near]) <= _OFF_NODE * np.diff(nodes).min())
        if off.any():
            bad = int(np.argmax(off))
            raise EcfitError(
                f"{path}:{lines[bad][0]}: {axis.name} = {x[bad]:g} is no node of that axis; the nearest is "
                f"{nodes[near[bad]]:g}"
            )
        index.append(near)
    shape = tuple(len(a) for a in axes)
    flat = np.ravel_multi_index(index, shape)
    times = np.bincount(flat, minlength=int(np.prod(shape)))
    if np.any(times != 1):
        bad = int(np.argmax(times != 1))
        place = zip(axes, np.unravel_index(bad, shape), strict=True)
        at = ", ".join(f"{a.name} = {a.nominal[i]:g}" for a, i in place)
        raise EcfitError(f"'{path}' has {times[bad]} values at {at}: expected one for each node")
    out = np.empty(times.size)
    out[flat] = data[:, -1]
    return out.reshape(shape)
