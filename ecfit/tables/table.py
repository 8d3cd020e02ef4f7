"""`Table`: float64 values with error estimates, axes, contract and provenance, in one NPZ file."""

import hashlib
import io
import json
import math
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.contract import Contract
from ecfit.coordinates import Axis, Grid
from ecfit.display import facts
from ecfit.errors import EcfitError
from ecfit.files import write_atomically
from ecfit.quadrature import FINE, STATUS, Status
from ecfit.tables.given import (
    as_albedo,
    claimed,
    content_key,
    error_estimates,
    given_axes,
    numbers,
    remarks,
)

_FORMAT = "ecfit-table-1"
# Bytes of unpacked parts: text has four a character, and an axis of a million nodes has eight million.
_MOST_HEADER, _MOST_NODES = 4_000_000, 8_000_000
_NPY_HEADER = 1_000


@dataclass(frozen=True, eq=False)
class Table:
    """A quantity on a grid.

    Attributes:
        values: float64, one dimension per axis, in the order of the axes.
        errors: absolute error estimate per entry, same shape; NaN where nobody knows.
        status: `ecfit.quadrature.Status` per entry, int8, same shape.
        axes: the axes.
        contract: the conventions that give the values their meaning.
        tolerance: the absolute error that was asked for; NaN where nobody asked.
        provenance: versions and the key of the request; of a given table, its source and key.

    Raises `EcfitError` where values, errors or status have not the shape of the axes.
    """

    values: np.ndarray
    errors: np.ndarray
    status: np.ndarray
    axes: tuple[Axis, ...]
    contract: Contract
    tolerance: float
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        shape = self.grid.shape
        for name, dtype in (("values", np.float64), ("errors", np.float64), ("status", np.int8)):
            array = np.asarray(getattr(self, name), dtype=dtype)
            if array.shape != shape:
                raise EcfitError(f"table: {name} have shape {array.shape}, the axes say {shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @classmethod
    def from_array(
        cls,
        values: Any,
        axes: Mapping[str, Any],
        contract: Contract | Mapping[str, Any],
        errors: Any = None,
        tolerance: float | None = None,
        *,
        stored: str | None = None,
        scale: float = 1.0,
        source: str = "array",
        finite: bool = True,
    ) -> "Table":
        """Somebody's own table: no model is needed.

        Args:
            values: real numbers, one dimension per axis, in the order of `axes`.
            axes: name -> `Axis`, increasing nodes, a count (equally spaced over [0, 1], ends included) or the
                name of a spacing over [0, 1] ("uniform": node at edge, "texel-centre": texel centre).
            contract: an `ecfit.Contract` or a mapping of its fields; the model may be "unknown".
            errors: absolute error of each E, or one for all, where they are known.
            tolerance: the error that the table was meant to have; entries above it are marked.
            stored: "1-E" where `values` hold 1 - E; by default what a contract's mapping says, else "E".
            scale: the number in `values` that stands for 1: 65535 for 16-bit tables, 100 for per cent.
            source: where the numbers come from, for the report.
            finite: whether NaN and infinity are refused (an audit wants to see them).

        Raises `EcfitError` for values that are not finite real numbers of the shape of the axes.
        """
        array = numbers(values, "values")
        made = given_axes(axes, array.shape)
        agreed, stored = claimed(contract, stored, made)
        array = as_albedo(array, stored, scale)
        bad = ~np.isfinite(array)
        if bad.any() and finite:
            place = Grid(made).nodes_at(np.flatnonzero(bad)[:1])
            first = ", ".join(f"{name} = {x[0]:.4g}" for name, x in place.items())
            raise EcfitError(
                f"{np.count_nonzero(bad)} of {bad.size} values are NaN or infinite, the first at {first}: "
                "a table needs a number everywhere"
            )
        known = error_estimates(errors, array.shape)
        if tolerance is None:
            tolerance = np.nan
        elif not (isinstance(tolerance, int | float) and 0.0 < tolerance < np.inf):
            raise EcfitError(f"tolerance must be a positive number, got {tolerance!r}")
        status = np.where(known > tolerance, Status.TOLERANCE_NOT_MET, Status.GIVEN)
        key = content_key(agreed, tolerance, made, (array, known))
        provenance = {"source": str(source), "key": key}
        return cls(array, known, status, made, agreed, float(tolerance), provenance)

    @property
    def grid(self) -> Grid:
        """The axes as a grid."""
        return Grid(self.axes)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the axes, in the order of the dimensions of `values`."""
        return self.grid.names

    @property
    def usable(self) -> np.ndarray:
        """Mask of the finite entries."""
        return np.isfinite(self.values)

    @property
    def estimated(self) -> bool:
        """Whether anything is known of the errors."""
        return not np.isnan(self.errors).all()

    @property
    def digest(self) -> str:
        """SHA-256 of the values, entry by entry (float64, C order): equal only where every bit is."""
        return hashlib.sha256(np.ascontiguousarray(self.values).tobytes()).hexdigest()

    def counts(self) -> dict[Status, int]:
        """Number of entries of each status."""
        return {s: int(np.count_nonzero(self.status == s)) for s in Status}

    def remarks(self) -> list[str]:
        """What in given values looks like another convention than the contract's."""
        given = bool(np.any(self.status == Status.GIVEN))
        return remarks(self.values, self.axes, self.contract) if given else []

    def describe(self) -> list[str]:
        """Lines for people: size, range, worst error estimate, and what did not converge."""
        finite = self.values[self.usable]
        lines = [" x ".join(map(str, self.grid.shape)) + f" entries of {self.contract.quantity}"]
        lines += [axis.describe() for axis in self.axes]
        if finite.size:
            lines.append(f"values in [{finite.min():.9g}, {finite.max():.9g}]")
            if self.estimated:
                worst = np.nanmax(self.errors[self.usable])
                asked = "" if np.isnan(self.tolerance) else f" (tolerance {self.tolerance:.2g})"
                lines.append(f"largest error estimate {worst:.2g}{asked}")
        if self.counts()[Status.GIVEN]:
            known = "" if self.estimated else ": no error estimate"
            lines.append(
                f"{STATUS[Status.GIVEN]}{known} (source: {self.provenance.get('source', 'unknown')})"
            )
        for status, count in self.counts().items():
            if status not in FINE and count:
                lines.append(f"WARNING: {count} entries: {STATUS[status]}{self._worst(status)}")
        return lines + [f"WARNING: {remark}" for remark in self.remarks()]

    def _worst(self, status: Status) -> str:
        """Where the entry of a status with the largest error estimate is, or the first, in words."""
        found = np.flatnonzero(self.status == status)
        errors = self.errors.ravel()[found]
        first = found[:1] if np.isnan(errors).all() else found[[np.nanargmax(errors)]]
        place = ", ".join(f"{name} = {x[0]:.4g}" for name, x in self.grid.nodes_at(first).items())
        return f", {'the worst' if found.size > 1 else 'it is'} at {place}"

    def __repr__(self) -> str:
        size = " x ".join(f"{a.name} {len(a)}" for a in self.axes)
        finite = self.values[self.usable]
        ends = f", in [{finite.min():.4g}, {finite.max():.4g}]" if finite.size else ", no finite entry"
        error = f", error <= {np.nanmax(self.errors):.2g}" if self.estimated else ""
        return f"<Table of {self.contract.quantity} of {self.contract.model}: {size}{ends}{error}>"

    def __str__(self) -> str:
        return "\n".join(self.describe())

    def _repr_html_(self) -> str:
        first, *rest = self.describe()
        return facts(first, [("table", line) for line in rest] + self.contract.describe())

    def save(self, path: str | Path) -> None:
        """Write one NPZ file (no pickle); a killed write leaves the old file."""
        header = {
            "format": _FORMAT,
            "axes": [
                {"name": a.name, "spacing": a.spacing, "through": a.through, "low": a.low, "high": a.high}
                for a in self.axes
            ],
            "contract": self.contract.to_dict(),
            "tolerance": None if np.isnan(self.tolerance) else self.tolerance,
            "provenance": dict(self.provenance),
        }
        arrays: dict[str, Any] = {"values": self.values, "errors": self.errors, "status": self.status}
        for i, axis in enumerate(self.axes):
            arrays[f"nodes_{i}"] = axis.nodes
            arrays[f"nominal_{i}"] = axis.nominal
        text = np.array(json.dumps(header))
        write_atomically(Path(path), lambda file: np.savez(file, header=text, **arrays))

    @classmethod
    def load(cls, path: str | Path) -> "Table":
        """Read a table written by `save`; raises `EcfitError` for anything else. Executes no code."""
        path = Path(path)
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            raise EcfitError(f"no such table: '{path}'") from None
        except OSError as error:
            raise EcfitError(f"cannot read '{path}': {error.strerror or error}") from None
        return cls.from_bytes(data, path)

    @classmethod
    def from_bytes(cls, data: bytes, path: str | Path) -> "Table":
        """The table of a file's bytes; messages name its `path`. Raises `EcfitError` as `load`."""
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as file:
                header = json.loads(str(_unpacked(file, "header", _MOST_HEADER)))
                if header["format"] != _FORMAT:
                    raise EcfitError(f"'{path}' is not an ecfit table of format {_FORMAT}")
                axes = tuple(
                    Axis(
                        a["name"],
                        _unpacked(file, f"nodes_{i}", _MOST_NODES),
                        _unpacked(file, f"nominal_{i}", _MOST_NODES),
                        a["spacing"],
                        a["through"],
                        float(a["low"]),
                        float(a["high"]),
                    )
                    for i, a in enumerate(header["axes"])
                )
                room = 8 * math.prod(map(len, axes)) + _NPY_HEADER
                return cls(
                    _unpacked(file, "values", room),
                    _unpacked(file, "errors", room),
                    _unpacked(file, "status", room),
                    axes,
                    Contract.from_dict(header["contract"]),
                    np.nan if header["tolerance"] is None else float(header["tolerance"]),
                    dict(header["provenance"]),
                )
        except EcfitError as error:
            raise EcfitError(f"'{path}' holds an invalid table: {error}") from None
        except (
            zipfile.BadZipFile, zlib.error, OSError, EOFError, KeyError, ValueError, TypeError,
            AttributeError, OverflowError, RuntimeError, MemoryError,
        ):  # fmt: skip
            raise EcfitError(
                f"'{path}' is damaged or not an ecfit table: delete it and run again to recompute it"
            ) from None


def _unpacked(file: Any, name: str, most: int) -> np.ndarray:
    """A member of an open archive, which may unpack to far more than the file (zeros by the gigabyte)."""
    size = file.zip.getinfo(f"{name}.npy").file_size
    if size > most:
        raise EcfitError(f"'{name}' has {size} bytes unpacked, at most {most} belong there")
    return file[name]
