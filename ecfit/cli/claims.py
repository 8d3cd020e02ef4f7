"""Somebody's own files: how they are read, and what they are claimed to hold."""

from pathlib import Path
from typing import Any, Literal, NamedTuple

from ecfit.cli.arguments import counts_of, given_axes, options_of
from ecfit.errors import refuse_ignored


class Foreign(NamedTuple):
    """How somebody's file is to be read: the options of `ecfit import`."""

    axis: tuple[str, ...]
    layout: str | None
    piece: str | None
    number: str | None
    spacing: str | None
    stored: Literal["E", "1-E"] | None
    scale: float | None
    order: str | None
    channel: str | None

    @property
    def says_itself(self) -> bool:
        """Whether the file or its layout says what it is; else its axes are given."""
        return self.layout is not None or not self.axis


def read_foreign(file: Path, how: Foreign, contract: Any, finite: bool = True) -> Any:
    """A table from somebody's file: by its axes, by a layout's name, or by what it says of itself."""
    from ecfit.contract import Contract
    from ecfit.tables import read_layout, read_table

    if how.says_itself:
        counts = counts_of(how.axis)
        done = read_layout(file, how.layout, contract=contract, counts=counts, channel=how.channel,
                           piece=how.piece, finite=finite)  # fmt: skip
        who = f"'{file}'" if how.layout is None else f"layout '{how.layout}'"
        said = how._asdict()
        stored = {k: said[k] for k in ("number", "spacing", "stored", "scale", "order")}
        refuse_ignored(f"{who} says itself how numbers are stored", stored)
        return done
    refuse_ignored("pieces are of a layout", {"piece": how.piece})
    if file.suffix.lower() in (".npy", ".exr"):
        refuse_ignored(f"a {file.suffix} file says the type of its numbers", {"number": how.number})
    names = None if how.order is None else [name.strip() for name in how.order.split(",")]
    axes = given_axes(how.axis, how.spacing)
    scale = 1.0 if how.scale is None else how.scale
    return read_table(file, axes, contract or Contract("unknown"), how.stored, names, channel=how.channel,
                      scale=scale, number=how.number, finite=finite)  # fmt: skip


def claim_of(
    model: str | None,
    option: tuple[str, ...],
    quantity: str | None,
    lobe: str | None,
    transport: str | None,
    exponent: int | None,
    own: bool,
) -> Any:
    """The contract that the options of `ecfit import` say, or None where they say none.

    `own`: whether the subject has a contract of its own, which only a whole one replaces.
    """
    from ecfit.tables import claim

    said = {"quantity": quantity, "lobe": lobe, "transport": transport}
    if model is None and own:
        why = "what the subject says of itself holds unless a model is claimed too (--model unknown for any)"
        refuse_ignored(why, {"option": option, **said, "exponent": exponent})
    said = {k: v for k, v in said.items() if v is not None}
    if model is None and not (option or said or exponent is not None):
        return None
    return claim(
        "unknown" if model is None else model,
        options_of(option),
        said.get("quantity", "directional-albedo"),
        said.get("lobe", "all"),
        said.get("transport", "energy"),
        {} if exponent is None else {"exponent": exponent},
    )
