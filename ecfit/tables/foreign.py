"""Foreign tables: somebody else's numbers, read from a file, as a table and as a study's request."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.bsdf import model as registered_model
from ecfit.contract import Contract
from ecfit.coordinates import Axis, Grid
from ecfit.errors import EcfitError, unknown
from ecfit.quantities import quantity
from ecfit.tables.given import given_axes
from ecfit.tables.layout import arranged
from ecfit.tables.numbers import number as number_of
from ecfit.tables.read_csv import read_csv
from ecfit.tables.read_exr import read_exr
from ecfit.tables.read_header import read_header
from ecfit.tables.read_npy import read_npy
from ecfit.tables.read_raw import read_raw
from ecfit.tables.table import Table

SOURCE = (".h", ".hpp", ".inc", ".c", ".cpp", ".tables", ".js")
RAW = (".bin", ".raw")
FORMATS = (".csv", ".exr", ".npy", *SOURCE, *RAW)


def read_table(
    path: str | Path,
    axes: Mapping[str, Any],
    contract: Contract | Mapping[str, Any],
    stored: str | None = None,
    order: Sequence[str] | None = None,
    *,
    channel: str | None = None,
    scale: float = 1.0,
    number: str | None = None,
    part: tuple[int, int] = (0, 1),
    errors: Any = None,
    finite: bool = True,
) -> Table:
    """A table from somebody's NPY, CSV, EXR, C source or raw file. Nothing in the file is executed.

    Args:
        path: the file; its ending says what it is.
        axes: name -> `Axis`, increasing nodes or a count (equally spaced over [0, 1], ends included).
        contract: an `ecfit.Contract` or a mapping of its fields; the model may be "unknown".
        stored: "1-E" where the file holds 1 - E; by default what a contract's mapping says, else "E".
        order: names of the axes as the file stores them, the one that varies fastest last ("-mu": from its
            last node to its first); by default the order of `axes`.
        channel: of an image (R or Y by default), of the last dimension of an NPY array, the column of a CSV
            file with a header (`value` by default), the name of an array in C source, or one of several
            numbers that follow each other entry by entry (R, G, 0, 1).
        scale: the stored number that stands for 1: 65535 for 16-bit tables, 100 for per cent.
        number: type of the numbers of a raw file ("uint16", "float16", ...), little-endian; decimals of text
            are rounded to it; in C source "float16" means that whole numbers are the bits of halves.
        part: which of how many tables of these axes that follow each other in the file.
        errors: absolute error of each E, or one for all, where they are known.
        finite: whether NaN and infinity are refused.

    Raises `EcfitError` for files that are missing, damaged, or not of the shape of the axes.
    """
    path = Path(path)
    made = given_axes(axes)
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise unknown("kind of table file", path.name, (f"*{f}" for f in FORMATS))
    if channel is not None and not isinstance(channel, str):
        raise EcfitError(f"channel must be a name, got {channel!r}")
    try:
        if not path.is_file():
            raise EcfitError(f"no such file: '{path}'" if not path.exists() else f"'{path}' is not a file")
        with path.open("rb"):
            pass  # so that a file that may not be read is told apart from a damaged one
        values = _values(path, kind, made, order, channel, number, part)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise EcfitError(
            f"cannot read '{str(path)!r}': {getattr(error, 'strerror', None) or error}"
        ) from None
    except MemoryError:
        raise EcfitError(f"'{path}' is too large for the memory") from None
    by_name = {axis.name: axis for axis in made}
    try:
        return Table.from_array(
            values, by_name, contract, errors, stored=stored, scale=scale, source=path.name, finite=finite
        )
    except EcfitError as error:
        raise EcfitError(f"'{path}': {error}") from None


def _values(
    path: Path,
    kind: str,
    axes: Sequence[Axis],
    order: Sequence[str] | None,
    channel: str | None,
    number: str | None,
    part: tuple[int, int],
) -> np.ndarray:
    """The numbers of a file, one dimension an axis."""
    which, parts = part
    if not (isinstance(which, int) and isinstance(parts, int) and 0 <= which < parts):
        raise EcfitError(f"part must be (which, of how many), got {part!r}")
    if kind == ".csv":
        if parts > 1:
            raise EcfitError("a CSV file holds one table: give each part a file")
        return _rounded(read_csv(path, axes, order, channel), number)
    count = Grid(tuple(axes)).size
    if kind in SOURCE:
        array = _rounded(read_header(path, parts * count, channel, number), number)
    elif kind in RAW:
        array = read_raw(path, parts * count, channel, number)
    else:
        array = (read_npy if kind == ".npy" else read_exr)(path, parts * count, channel)
    if parts > 1:
        array = array.ravel()[which * count : (which + 1) * count]
    return arranged(array, axes, order, f"'{path}'")


def _rounded(array: np.ndarray, number: str | None) -> np.ndarray:
    """Decimals as the type that they stand for, as a compiler takes them."""
    if number is None or number_of(number).whole:
        return array
    with np.errstate(over="ignore"):
        return array.astype(number_of(number).dtype).astype(np.float64)


def claim(
    model: str,
    options: Mapping[str, Any],
    quantity_name: str,
    lobe: str,
    transport: str,
    quantity_options: Mapping[str, int],
) -> Contract:
    """The contract that somebody claims for a table: words are options, numbers parameters.

    Raises `EcfitError` for names that are not registered, and for options that a registered model does not
    have; of the model "unknown" any option may be said. What is not said is not filled in.
    """
    if model != "unknown":
        registered_model(model, **options)
    words = {k: v for k, v in options.items() if isinstance(v, str)}
    return Contract(
        model=model,
        options=words,
        parameters={k: float(v) for k, v in options.items() if k not in words},
        quantity=quantity_name,
        lobe=lobe,
        transport=transport,
        quantity_options=quantity(quantity_name, lobe, transport, **quantity_options).options(),
    )


@dataclass(frozen=True, eq=False)
class Given:
    """A table that is there already, in the place of a `Request`: nothing is left to compute."""

    table: Table

    @property
    def grid(self) -> Grid:
        """Of the table."""
        return self.table.grid

    @property
    def contract(self) -> Contract:
        """Of the table: what is claimed."""
        return self.table.contract

    @property
    def key(self) -> str:
        """Content hash of the table."""
        return self.table.provenance["key"]

    def compute(self, progress: Callable[[int], None] | None = None) -> Table:
        """The table."""
        if progress is not None:
            progress(int(np.prod(self.grid.shape)))
        return self.table
