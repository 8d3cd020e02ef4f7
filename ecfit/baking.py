"""`bake`: a model, a fit or a table on the nodes of a consumer's layout, written as the consumer reads it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.approximation import Approximation, find, published_names, shipped
from ecfit.bsdf import BSDF, models
from ecfit.bsdf import model as registered_model
from ecfit.coordinates import Axis, Grid
from ecfit.errors import EcfitError, unknown
from ecfit.tables import Table
from ecfit.tables.consumers import Channel, Layout, Piece, layout
from ecfit.tables.tabulate import tabulate
from ecfit.tables.write import Written, remarks, write_table

Source = Table | Approximation | BSDF | str | Path


@dataclass(frozen=True)
class Baked:
    """Tables on a layout's nodes, ready to be written.

    Attributes:
        layout: with the numbers of nodes that were asked for.
        tables: one a channel, for each piece in turn.
    """

    layout: Layout
    tables: tuple[Table, ...]

    def save(self, path: str | Path, **settings: Any) -> Written:
        """Write the file; `settings` are those of `ecfit.write_table`."""
        return write_table(self.tables, path, self.layout, **settings)

    def remarks(self) -> list[str]:
        """Where the tables are of another model than the consumer's own shading code."""
        return remarks(self.layout, self.tables)


def bake(
    sources: Source | Sequence[Source],
    layout_: str | Layout = "plain",
    *,
    axes: Mapping[str, Axis | int] | None = None,
    options: Mapping[str, Any] | None = None,
    transport: str = "energy",
    lobe: str = "all",
    quantity: str = "directional-albedo",
    tolerance: float = 1e-7,
    progress: Callable[[int], None] | None = None,
) -> Baked:
    """Tables on the nodes of a layout.

    Args:
        sources: a model (or its name), which is integrated for every channel and piece; or for each of them a
            table, an approximation, a file of one (NPZ, JSON) or the name of a published or shipped fit.
        layout_: the name of a layout (`ecfit list`), or one.
        axes: counts in the place of the layout's; of "plain", the axes that a model or a fit is put on.
        options: of the model, in the place of the layout's: its words and numbers.
        lobe, transport, quantity: what a model is integrated to, where the layout leaves it open.
        tolerance: of the integrals.
        progress: called with the number of entries that finished since the last call.

    Raises `EcfitError` for sources that do not make up the layout's channels and for tables on other nodes.
    """
    plan = _sized(layout(layout_), axes or {})
    given = [sources] if isinstance(sources, Table | Approximation | BSDF | str | Path) else list(sources)
    opened = [_opened(s) for s in given]
    slots = [(piece, channel) for piece in plan.pieces for channel in plan.channels]
    grid = _grid(plan, axes or {}, opened)
    if len(opened) == 1 and isinstance(opened[0], BSDF | _Named):
        made = []
        for piece, channel in slots:
            bsdf = _model(opened[0], plan, piece, options or {})
            what = channel.quantity or quantity
            settings = {"quantity": what, "lobe": lobe, "transport": transport, "tolerance": tolerance}
            made.append(tabulate(bsdf, grid, **settings, progress=progress))
        return Baked(plan, tuple(made))
    if options:
        raise EcfitError("options are of a model: a table or a fit has its own")
    if len(opened) != len(slots):
        wanted = ", ".join(_slot(p, c) for p, c in slots)
        raise EcfitError(
            f"layout '{plan.name}' takes a model, or {len(slots)} tables or fits ({wanted}), "
            f"got {len(opened)}"
        )
    return Baked(plan, tuple(_table(s, grid) for s in opened))


@dataclass(frozen=True)
class _Named:
    """A registered model that is yet to be made, with options that the layout may add."""

    name: str


def _opened(source: Source) -> Table | Approximation | BSDF | _Named:
    if isinstance(source, Table | Approximation | BSDF):
        return source
    name = str(source)
    if name.endswith(".npz"):
        return Table.load(name)
    if name.endswith(".json") or name in shipped() or name in published_names():
        return find(name)
    if name in models():
        return _Named(name)
    raise unknown("model, shipped or published fit", name, [*models(), *shipped(), *published_names()])


def _sized(plan: Layout, axes: Mapping[str, Axis | int]) -> Layout:
    """The layout with other numbers of nodes."""
    if not plan.axes:
        return plan
    known = {n.name: n for n in plan.axes}
    for name, what in axes.items():
        if name not in known:
            raise unknown(f"axis of layout '{plan.name}'", name, known)
        if isinstance(what, Axis | bool) or what < 2:
            raise EcfitError(f"layout '{plan.name}' has nodes of its own: axes give counts, 2 or more")
        known[name] = replace(known[name], count=int(what))
    return replace(plan, axes=tuple(known.values()))


def _grid(plan: Layout, axes: Mapping[str, Axis | int], sources: Sequence[Any]) -> dict[str, Any]:
    """Axes by name, in the order of the layout."""
    if plan.axes:
        return {n.name: n.axis() for n in plan.axes}
    if axes:
        return dict(axes)
    table = next((s for s in sources if isinstance(s, Table)), None)
    if table is None:
        raise EcfitError("layout 'plain' has no axes of its own: give them (--axis r=32 --axis mu=32)")
    return {a.name: a for a in table.axes}


def _model(source: BSDF | _Named, plan: Layout, piece: Piece, options: Mapping[str, Any]) -> BSDF:
    """The model as the consumer evaluates it, but for what was asked for."""
    if isinstance(source, BSDF):
        return source
    known = models()[source.name].option_choices()
    chosen = {k: v for k, v in {**plan.options, **piece.options}.items() if k in known}
    chosen.update(options)
    return registered_model(source.name, **chosen)


def _table(source: Any, grid: Mapping[str, Any]) -> Table:
    if isinstance(source, Table):
        return source
    if not isinstance(source, Approximation):
        raise EcfitError("one model makes all channels of a layout: give it alone")
    axes = [a if isinstance(a, Axis) else _unit(name, a, source) for name, a in grid.items()]
    nodes, order = source.nodes_of({a.name: a.nodes for a in axes}, source.contract.parameters)
    _within(source, nodes)
    values = np.transpose(source.on_grid(nodes), np.argsort(order)).reshape(Grid(tuple(axes)).shape)
    return Table.from_array(values, {a.name: a for a in axes}, source.contract, source=source.name)


def _within(source: Approximation, nodes: Sequence[np.ndarray]) -> None:
    """Raises `EcfitError` for nodes outside the domain of a fit, where its values mean nothing."""
    for name, x, (low, high) in zip(source.variables, nodes, source.domain, strict=False):
        slack = 1e-9 * max(1.0, abs(high))
        if x.min() < low - slack or x.max() > high + slack:
            raise EcfitError(
                f"'{source.name}' is made for {name} in [{low:g}, {high:g}], the layout has nodes in "
                f"[{x.min():g}, {x.max():g}]"
            )


def _unit(name: str, count: int, source: Approximation) -> Axis:
    """`count` nodes over the whole domain of a fit's variable; [0, 1] of a coordinate in another view."""
    ends = dict(zip(source.variables, source.domain, strict=True)).get(name, (0.0, 1.0))
    return Axis.spaced(name, count, *ends)


def _slot(piece: Piece, channel: Channel) -> str:
    return " ".join(w for w in (piece.name, channel.quantity or "any quantity") if w)
