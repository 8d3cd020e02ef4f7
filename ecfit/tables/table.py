"""`Table`: float64 values with error estimates, axes, contract and provenance, in one NPZ file."""

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.contract import Contract
from ecfit.coordinates import Axis, Grid
from ecfit.errors import EcfitError
from ecfit.files import write_atomically
from ecfit.quadrature import STATUS, Status

_FORMAT = "ecfit-table-1"


@dataclass(frozen=True, eq=False)
class Table:
    """A quantity on a grid.

    Attributes:
        values: float64, one dimension per axis, in the order of the axes.
        errors: absolute error estimate per entry, same shape.
        status: `ecfit.quadrature.Status` per entry, int8, same shape.
        axes: the axes.
        contract: the conventions that give the values their meaning.
        tolerance: the absolute error that was asked for.
        provenance: versions and the key of the request.
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

    @property
    def grid(self) -> Grid:
        return Grid(self.axes)

    @property
    def names(self) -> tuple[str, ...]:
        return self.grid.names

    @property
    def usable(self) -> np.ndarray:
        """Mask of the finite entries."""
        return np.isfinite(self.values)

    def counts(self) -> dict[Status, int]:
        """Number of entries of each status."""
        return {s: int(np.count_nonzero(self.status == s)) for s in Status}

    def describe(self) -> list[str]:
        """Lines for people: size, range, worst error estimate, and what did not converge."""
        finite = self.values[self.usable]
        lines = [" x ".join(map(str, self.grid.shape)) + f" entries of {self.contract.quantity}"]
        lines += [axis.describe() for axis in self.axes]
        if finite.size:
            lines.append(f"values in [{finite.min():.9g}, {finite.max():.9g}]")
            worst = self.errors[self.usable].max()
            lines.append(f"largest error estimate {worst:.2g} (tolerance {self.tolerance:.2g})")
        for status, count in self.counts().items():
            if status != Status.CONVERGED and count:
                lines.append(f"WARNING: {count} entries: {STATUS[status]}")
        return lines

    def save(self, path: str | Path) -> None:
        """Write one NPZ file (no pickle); a killed write leaves the old file."""
        header = {
            "format": _FORMAT,
            "axes": [
                {"name": a.name, "spacing": a.spacing, "through": a.through, "low": a.low, "high": a.high}
                for a in self.axes
            ],
            "contract": self.contract.to_dict(),
            "tolerance": self.tolerance,
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
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as file:
                header = json.loads(str(file["header"]))
                if header["format"] != _FORMAT:
                    raise EcfitError(f"'{path}' is not an ecfit table of format {_FORMAT}")
                axes = tuple(
                    Axis(
                        a["name"],
                        file[f"nodes_{i}"],
                        file[f"nominal_{i}"],
                        a["spacing"],
                        a["through"],
                        float(a["low"]),
                        float(a["high"]),
                    )
                    for i, a in enumerate(header["axes"])
                )
                return cls(
                    file["values"],
                    file["errors"],
                    file["status"],
                    axes,
                    Contract.from_dict(header["contract"]),
                    float(header["tolerance"]),
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
