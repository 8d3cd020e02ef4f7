"""`write_table`: a table in a consumer's layout, as EXR, NPY, CSV, C source or raw numbers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.coordinates import Axis, viewed
from ecfit.errors import EcfitError, refuse_ignored, unknown
from ecfit.files import write_atomically, write_text
from ecfit.tables.consumers import Layout, Piece, layout
from ecfit.tables.foreign import RAW, SOURCE
from ecfit.tables.given import STORED
from ecfit.tables.numbers import number as number_of
from ecfit.tables.said import ATTRIBUTE, axis_from_dict, axis_to_dict, line
from ecfit.tables.table import Table
from ecfit.tables.write_exr import write_exr
from ecfit.tables.write_header import header_text

ENDINGS = (".csv", ".exr", ".npy", ".h", ".hpp", ".inc", ".bin", ".raw")
# Nodes of a table are a layout's within the rounding of the maps between them.
_SAME = 1e-9


@dataclass(frozen=True)
class Written:
    """A file that was written.

    Attributes:
        path: of the file.
        layout: its layout.
        shape: numbers along each dimension, the last fastest; channels are the last where there are several.
        rounding: the most by which rounding moved a value; `bound`: the most that it could.
    """

    path: Path
    layout: Layout
    shape: tuple[int, ...]
    rounding: float
    bound: float

    def describe(self) -> list[str]:
        """Lines for people."""
        size = " x ".join(map(str, self.shape))
        kept = f"{size} numbers, {self.layout.number} of {self.layout.stored}"
        return [
            f"written: {self.path} (layout {self.layout.name}: {kept})",
            f"rounding moves values by {self.rounding:.2g} at most (bound {self.bound:.2g})",
        ]


def write_table(
    tables: Table | Sequence[Table],
    path: str | Path,
    layout_: str | Layout = "plain",
    *,
    number: str | None = None,
    stored: str | None = None,
    order: Sequence[str] | None = None,
    name: str | None = None,
    parts: bool = False,
) -> Written:
    """Write a table in a layout; what the file says of itself is read back by `read_layout`.

    Args:
        tables: one, or one for each channel of the layout (for each piece, its channels).
        path: the file; its ending says the format: EXR, NPY, CSV, C source (.h) or raw numbers (.bin).
        layout_: a layout or the name of one; "plain" keeps the table's axes.
        number, stored: in the place of the layout's: "uint16", "float16", ...; "E" or "1-E".
        order: for "plain": the axes as they are to be stored, the last varies fastest; "-mu": backwards.
        name: of the array in C, "ecfit_table" by default.
        parts: in EXR, whether slices are parts instead of standing below each other.

    Raises `EcfitError` where the tables' nodes are not the layout's (they are not interpolated: integrate on
    the layout's nodes with `ecfit.bake`), for numbers that the type cannot hold, and for a name or parts that
    would have no effect.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in ENDINGS:
        raise unknown("kind of table file", path.name, (f"*{e}" for e in ENDINGS))
    if kind not in SOURCE:
        refuse_ignored(f"only arrays of C source have a name, not {kind}", {"name": name})
    given = [tables] if isinstance(tables, Table) else list(tables)
    plan = layout(layout_)
    plan = replace(plan, number=number or plan.number, stored=stored or plan.stored)
    if plan.stored not in STORED:
        raise unknown("stored value", plan.stored, STORED)
    kept = number_of(plan.number)
    wanted = len(plan.pieces) * len(plan.channels)
    if len(given) != wanted or not all(isinstance(t, Table) for t in given):
        names = [
            " ".join(w for w in (p.name, c.quantity or "") if w) for p in plan.pieces for c in plan.channels
        ]
        listed = ", ".join(names) if wanted > 1 else "one"
        raise EcfitError(f"layout '{plan.name}' takes {wanted} table(s) ({listed}), got {len(given)}")
    _check_quantities(plan, given)
    orders = [_order(plan, piece, given[0], order) for piece in plan.pieces]
    arrays = []
    for i, table in enumerate(given):
        where = orders[i // len(plan.channels)]
        values = 1.0 - table.values if plan.stored == "1-E" else table.values
        if not np.isfinite(values).all():
            raise EcfitError("the table has entries that are not finite: no renderer wants them")
        arrays.append(_in_order(values, _axes(plan, table), where))
    exact = np.stack(arrays).reshape(len(plan.pieces), len(plan.channels), *arrays[0].shape)
    encoded = kept.encode(np.moveaxis(exact, 1, -1))
    back = np.moveaxis(kept.decode(encoded), -1, 1)
    entries = encoded[0] if len(plan.pieces) == 1 else encoded.reshape(-1, *encoded.shape[2:])
    moved, bound = float(np.abs(back - exact).max()), kept.step(float(np.abs(exact).max()))
    if parts and not (kind == ".exr" and entries.ndim > 3):  # an image is (height, width, channels)
        raise EcfitError("parts are for the slices of 3D tables in EXR files: leave parts out")
    said = _said(plan, given, orders, bound)
    _put(path, kind, entries, plan, said, "ecfit_table" if name is None else name, parts)
    shape = entries.shape if len(plan.channels) > 1 else entries.shape[:-1]
    return Written(path, plan, shape, moved, bound)


def _check_quantities(plan: Layout, tables: Sequence[Table]) -> None:
    for i, table in enumerate(tables):
        channel, piece = plan.channels[i % len(plan.channels)], plan.pieces[i // len(plan.channels)]
        if channel.quantity not in (None, table.contract.quantity):
            raise EcfitError(
                f"layout '{plan.name}': channel {channel.name or 0} holds {channel.quantity}, the table "
                f"{table.contract.quantity}"
            )
        for option, value in piece.options.items():
            if table.contract.options.get(option, value) != value:
                raise EcfitError(f"layout '{plan.name}': the piece '{piece.name}' is of {option} = {value}")


def remarks(plan: Layout, tables: Sequence[Table]) -> list[str]:
    """Where tables are of another model than the consumer's own shading code: allowed, but told."""
    out = []
    for table in tables:
        contract = table.contract
        if plan.model not in ("unknown", contract.model) and contract.model != "unknown":
            out.append(f"{plan.name} evaluates a {plan.model}, this is a table of {contract.model}")
        for option, value in plan.options.items():
            if contract.options.get(option, value) != value:
                out.append(f"{plan.name} has {option} = {value}, this table {contract.options[option]}")
    return list(dict.fromkeys(out))


def _axes(plan: Layout, table: Table) -> list[Axis]:
    """The table's axes under the layout's names. Raises `EcfitError` where their nodes are others."""
    if not plan.axes:
        return list(table.axes)
    out = []
    for axis in table.axes:
        for nodes in plan.axes:
            wanted = nodes.axis(len(axis))
            found = viewed(nodes.name, axis.name, axis.nodes)
            if found is None:
                continue
            if np.abs(found - wanted.nodes).max() > _SAME:
                raise EcfitError(
                    f"layout '{plan.name}' has other nodes of {nodes.name} than the table: tables are not "
                    "interpolated; integrate or sample on the layout's nodes (ecfit export-table MODEL)"
                )
            out.append(wanted)
    if sorted(a.name for a in out) != sorted(n.name for n in plan.axes):
        raise EcfitError(
            f"layout '{plan.name}' is of {', '.join(n.name for n in plan.axes)}, the table of "
            f"{', '.join(table.names)}"
        )
    return out


def _order(plan: Layout, piece: Piece, table: Table, order: Sequence[str] | None) -> list[str]:
    if order is None:
        return plan.order(piece) if plan.axes else list(table.names)
    if plan.axes:
        raise EcfitError(f"layout '{plan.name}' has its own order: leave order out, or use layout 'plain'")
    if sorted(n.removeprefix("-") for n in order) != sorted(table.names):
        raise EcfitError(f"order must name each axis once ({', '.join(table.names)}), got {', '.join(order)}")
    return list(order)


def _in_order(values: np.ndarray, axes: Sequence[Axis], order: Sequence[str]) -> np.ndarray:
    """The inverse of `ecfit.tables.layout.arranged`."""
    names = [a.name for a in axes]
    out = np.transpose(values, [names.index(n.removeprefix("-")) for n in order])
    return np.flip(out, tuple(i for i, n in enumerate(order) if n.startswith("-")))


def _said(plan: Layout, tables: Sequence[Table], orders: Sequence[list[str]], bound: float) -> dict[str, Any]:
    return {
        "layout": plan.name,
        "axes": [axis_to_dict(a) for a in _axes(plan, tables[0])],
        "pieces": [{"name": p.name, "order": o} for p, o in zip(plan.pieces, orders, strict=True)],
        "channels": [c.name for c in plan.channels],
        "stored": plan.stored,
        "number": plan.number,
        "rounding": bound,
        "errors": [_error(t, bound) for t in tables],
        "contracts": [t.contract.to_dict() for t in tables],
        "sources": [str(t.provenance.get("source", "ecfit")) for t in tables],
        "keys": [str(t.provenance.get("key", "")) for t in tables],
    }


def _error(table: Table, rounding: float) -> float | None:
    """The most by which an entry of the file is off, as far as the table knows its own errors; else None."""
    known = table.errors[np.isfinite(table.errors)]
    return float(known.max()) + rounding if known.size else None


def _comment(plan: Layout, said: dict[str, Any], tables_shape: tuple[int, ...]) -> list[str]:
    """What people read first, then the line that ecfit reads."""
    contract = said["contracts"][0]
    settings = {**contract["options"], **contract["parameters"]}
    text = [f"{' x '.join(map(str, tables_shape))} numbers, written by ecfit in the layout '{plan.name}'"]
    known = [e for e in said["errors"] if e is not None]
    off = f", off by at most {max(known):.2g} in all" if known else ""
    text.append(f"{plan.number} of {plan.stored}, rounded by at most {said['rounding']:.2g}{off}")
    for piece in said["pieces"]:
        order = f"order {', '.join(piece['order'])} (the last varies fastest; - runs backwards)"
        text.append(f"{piece['name']}: {order}" if piece["name"] else order)
    text += [axis_from_dict(a).describe() for a in said["axes"]]
    if len(said["channels"]) > 1:
        quantities = (c["quantity"] for c in said["contracts"])
        pairs = zip(said["channels"], quantities, strict=False)
        text.append("channels " + ", ".join(f"{c} = {q}" for c, q in pairs))
    words = "".join(f", {k} = {v}" for k, v in sorted(settings.items()))
    text.append(f"{contract['quantity']} of {contract['model']}{words}")
    text.append(f"lobe {contract['lobe']}, {contract['transport']} transport")
    return [*text, line(said)]


def _put(
    path: Path, kind: str, entries: np.ndarray, plan: Layout, said: dict[str, Any], name: str, parts: bool
) -> None:
    """Write entries of shape (..., channels)."""
    comment = _comment(plan, said, entries.shape[:-1])
    if kind in SOURCE:
        # One line of source for each run of the fastest axis.
        rows = entries.reshape(1, *entries.shape).reshape(-1, entries.shape[-2] * entries.shape[-1])
        write_text(path, header_text(rows, number_of(plan.number), name, comment))
    elif kind in RAW:
        write_atomically(path, lambda file: file.write(np.ascontiguousarray(entries).tobytes()))
    elif kind == ".npy":
        array = entries if len(plan.channels) > 1 else entries[..., 0]
        write_atomically(path, lambda file: np.save(file, np.ascontiguousarray(array), allow_pickle=False))
    elif kind == ".csv":
        write_text(path, _csv(entries, plan, comment))
    else:
        names = [c.name or "Y" for c in plan.channels]
        attributes = {ATTRIBUTE: line(said).partition(" ")[2], "comments": "\n".join(comment[:-1])}
        write_atomically(path, lambda file: write_exr(file, entries, names, attributes, parts))


def _csv(entries: np.ndarray, plan: Layout, comment: Sequence[str]) -> str:
    """A matrix: rows of the fastest axis. Raises `EcfitError` for several channels or pieces."""
    if len(plan.channels) > 1 or len(plan.pieces) > 1:
        raise EcfitError("a CSV file holds one table: write each channel as its own, in layout 'plain'")
    rows = entries[..., 0] if entries.ndim > 2 else entries[:, 0][None]
    rows = rows.reshape(-1, rows.shape[-1])
    digits = ".17g" if plan.number == "float64" else ".9g"
    lines = [",".join(format(x, digits) for x in row.tolist()) for row in rows]
    return "\n".join([*(f"# {text}" for text in comment), *lines, ""])
