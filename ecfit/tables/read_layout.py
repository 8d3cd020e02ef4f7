"""`read_layout`: a table from a file in a consumer's layout, or from one that says itself what it is."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError, unknown
from ecfit.tables.consumers import Layout, layout
from ecfit.tables.foreign import read_table
from ecfit.tables.numbers import number as number_of
from ecfit.tables.said import axis_from_dict, read_said
from ecfit.tables.table import Table


def read_layout(
    path: str | Path,
    layout_: str | Layout | None = None,
    *,
    contract: Contract | None = None,
    counts: Mapping[str, int] | None = None,
    channel: str | None = None,
    piece: str | None = None,
    finite: bool = True,
) -> Table:
    """A table from a file in a named layout; from a file of `write_table` (EXR, CSV, C) without naming one.

    Args:
        path: the file.
        layout_: its layout, or None where the file says what it is.
        contract: what the table is claimed to be; by default what the file says, else what the layout's
            consumer evaluates.
        counts: nodes of axes that has other numbers of them than the layout.
        channel: one of the layout's channels, the first by default; in C source with several arrays the
            array's name, or both ("table.R").
        piece: one of the tables that follow each other in the file.
        finite: whether NaN and infinity are refused.

    Raises `EcfitError` for an unknown layout, channel or piece and all that `read_table` refuses.
    """
    path = Path(path)
    if layout_ is None:
        said = read_said(path) if path.is_file() else None
        if said is None:
            raise EcfitError(
                f"'{path}' does not say what it is: give its axes, or its layout"
                if path.is_file()
                else f"no such file: '{path}'"
            )
        return _from_said(path, said, contract, channel, piece, finite)
    plan = layout(layout_)
    if not plan.axes:
        raise EcfitError("layout 'plain' has no axes of its own: give them")
    for name in counts or {}:
        if name not in [a.name for a in plan.axes]:
            raise unknown(f"axis of layout '{plan.name}'", name, (a.name for a in plan.axes))
    axes = {a.name: a.axis((counts or {}).get(a.name)) for a in plan.axes}
    array, _, within = (channel or "").rpartition(".")
    if channel is not None and not array and channel not in [c.name for c in plan.channels]:
        array, within = channel, ""
    which = plan.channel(within or None)
    chosen = plan.piece(piece)
    if contract is None:
        quantity = plan.channels[which].quantity or "directional-albedo"
        options = {**plan.options, **chosen.options}
        contract = Contract(plan.model, options if plan.model != "unknown" else {}, quantity=quantity)
    return read_table(
        path,
        axes,
        contract,
        plan.stored,
        plan.order(chosen),
        channel=_channel(path, array, which, plan),
        scale=number_of(plan.number).one,
        number=plan.number,
        part=(plan.pieces.index(chosen), len(plan.pieces)),
        finite=finite,
    )


def _channel(path: Path, array: str, which: int, plan: Layout) -> str | None:
    """What `read_table` calls the channel in a file of this kind."""
    several = len(plan.channels) > 1
    if path.suffix.lower() == ".exr":
        return plan.channels[which].name or None
    index = str(which) if several else ""
    return f"{array}.{index}" if array and index else (array or index or None)


def _from_said(
    path: Path,
    said: Mapping[str, Any],
    contract: Contract | None,
    channel: str | None,
    piece: str | None,
    finite: bool,
) -> Table:
    try:
        made: dict[str, Axis] = {}
        for data in said["axes"]:
            axis = axis_from_dict(data)
            made[axis.name] = axis
        channels, pieces = [str(c) for c in said["channels"]], list(said["pieces"])
        names = [str(p["name"]) for p in pieces]
        if channel is not None and channel not in channels:
            if channels == [""]:
                raise EcfitError(f"'{path}' has no channel '{channel}', it has one: leave channel out")
            raise unknown("channel", channel, channels)
        if len(names) == 1 and piece not in (None, names[0]):
            raise EcfitError(f"'{path}' has no piece '{piece}', it is one table: leave piece out")
        if len(names) > 1 and piece not in names:
            raise EcfitError(f"'{path}': which piece? Expected one of {', '.join(names)}")
        which = 0 if channel is None else channels.index(channel)
        part = 0 if piece is None else names.index(piece)
        order = [str(n) for n in pieces[part]["order"]]
        number, stored = str(said["number"]), str(said["stored"])
        slot = part * len(channels) + which
        claimed = contract or Contract.from_dict(said["contracts"][slot])
        error = said["errors"][slot] if "errors" in said else None
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as fault:
        raise EcfitError(f"'{path}': what it says of itself is damaged ({fault})") from None
    in_file = None if len(channels) == 1 else str(which)
    if path.suffix.lower() == ".exr":
        in_file = channels[which] or None
    return read_table(
        path,
        made,
        claimed,
        stored,
        # A matrix of a CSV file takes its order like any other.
        order,
        channel=in_file,
        scale=number_of(number).one,
        number=number,
        part=(part, len(names)),
        errors=error,
        finite=finite,
    )
