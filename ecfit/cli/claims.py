"""Somebody's own files: how they are read, and what they are claimed to hold."""

from pathlib import Path
from typing import Any, Literal, NamedTuple

from ecfit.cli.arguments import counts_of, given_axes, options_of


class Foreign(NamedTuple):
    """How somebody's file is to be read: the options of `ecfit import`."""

    axis: tuple[str, ...]
    layout: str | None
    piece: str | None
    number: str | None
    spacing: str
    stored: Literal["E", "1-E"]
    scale: float
    order: str | None
    channel: str | None


def read_foreign(file: Path, how: Foreign, contract: Any, finite: bool = True) -> Any:
    """A table from somebody's file: by its axes, by a layout's name, or by what it says of itself."""
    from ecfit.contract import Contract
    from ecfit.tables import read_layout, read_table

    if how.layout is not None or not how.axis:
        counts = counts_of(how.axis)
        return read_layout(file, how.layout, contract=contract, counts=counts, channel=how.channel,
                           piece=how.piece, finite=finite)  # fmt: skip
    names = None if how.order is None else [name.strip() for name in how.order.split(",")]
    axes = given_axes(how.axis, how.spacing)
    return read_table(file, axes, contract or Contract("unknown"), how.stored, names, channel=how.channel,
                      scale=how.scale, number=how.number, finite=finite)  # fmt: skip


def claim_of(
    model: str | None, option: tuple[str, ...], quantity: str, lobe: str, transport: str, exponent: int | None
) -> Any:
    """The contract that the options of `ecfit import` say, or None where they say none."""
    from ecfit.tables import claim

    settings = {} if exponent is None else {"exponent": exponent}
    said = (quantity, lobe, transport) != ("directional-albedo", "all", "energy") or option or settings
    if model is None and not said:
        return None
    return claim(model or "unknown", options_of(option), quantity, lobe, transport, settings)
