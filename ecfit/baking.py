"""`bake`: a model, a fit or a table on the nodes of a consumer's layout, written as the consumer reads it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.approximation import Approximation, find, published_names, shipped
from ecfit.bsdf import BSDF, models
from ecfit.bsdf import model as registered_model
from ecfit.coordinates import Axis, Grid, viewed
from ecfit.errors import EcfitError, refuse_ignored, unknown
from ecfit.progress import Progress
from ecfit.quantities import quantity as quantity_of
from ecfit.tables import Table
from ecfit.tables.consumers import Channel, Layout, Piece, layout
from ecfit.tables.tabulate import default_range, tabulate
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
    axes: Mapping[str, Any] | None = None,
    spacing: str | None = None,
    options: Mapping[str, Any] | None = None,
    transport: str | None = None,
    lobe: str | None = None,
    quantity: str | None = None,
    tolerance: float | None = None,
    progress: Progress | None = None,
) -> Baked:
    """Tables on the nodes of a layout.

    Args:
        sources: a model (or its name), which is integrated for every channel and piece; or for each of them a
            table, an approximation, a file of one (NPZ, JSON) or the name of a published or shipped fit.
        layout_: the name of a layout (`ecfit list`), or one.
        axes: counts in the place of the layout's; of "plain" name -> `Axis`, increasing nodes or a count,
            which is spaced over the model's own range or the domain of the fit.
        spacing: of counts of "plain", "uniform" by default.
        options: of the model, in the place of the layout's: its words and numbers.
        lobe, transport: what a model is integrated to; "all", "energy" by default.
        quantity: the same where the layout leaves it open; "directional-albedo" by default.
        tolerance: of the integrals; 1e-7 by default.
        progress: told of each table that is integrated.

    Raises `EcfitError` for sources that do not make up the layout's channels, for tables on other nodes, and
    for arguments that would have no effect.
    """
    if not isinstance(axes, Mapping | None):
        raise EcfitError(f"axes must be a mapping such as {{'r': 64, 'mu': 64}}, got {axes!r}")
    plan = _sized(layout(layout_), axes or {})
    if plan.axes:
        refuse_ignored(f"layout '{plan.name}' has nodes of its own", {"spacing": spacing})
    wanted = _Wanted(plan, axes or {}, spacing)
    given = [sources] if isinstance(sources, Table | Approximation | BSDF | str | Path) else list(sources)
    opened = [_opened(s) for s in given]
    settings = {"quantity": quantity, "lobe": lobe, "transport": transport, "tolerance": tolerance}
    if len(opened) == 1 and isinstance(opened[0], BSDF | _Named):
        tables = _integrated(opened[0], wanted, options or {}, settings, progress or Progress())
        return Baked(plan, tuple(tables))
    why = "tables and fits say themselves what they are of"
    refuse_ignored(why, {"options": options, **settings})
    slots = [_slot(p, c.quantity or "any quantity") for p, c in _slots(plan)]
    if len(opened) != len(slots):
        raise EcfitError(
            f"layout '{plan.name}' takes a model, or {len(slots)} tables or fits ({', '.join(slots)}), "
            f"got {len(opened)}"
        )
    return Baked(plan, tuple(_table(s, wanted) for s in opened))


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
        if isinstance(what, bool) or not isinstance(what, int | np.integer) or what < 2:
            got = repr(what) if isinstance(what, int | float | str) else type(what).__name__
            raise EcfitError(
                f"layout '{plan.name}' has nodes of its own: axes give counts, 2 or more, got {name} = {got}"
            )
        known[name] = replace(known[name], count=int(what))
    return replace(plan, axes=tuple(known.values()))


Ends = Callable[[str], tuple[float, float]]


@dataclass(frozen=True)
class _Wanted:
    """The nodes that are asked for: a layout's, or of one without axes those that are given."""

    plan: Layout
    axes: Mapping[str, Any]
    spacing: str | None

    def nodes(self, ends: Ends) -> dict[str, Axis]:
        """Axes by name; counts are spaced between the ends of a coordinate."""
        if self.plan.axes:
            return {n.name: n.axis() for n in self.plan.axes}
        if not self.axes:
            raise EcfitError("layout 'plain' has no axes of its own: give them (--axis r=32 --axis mu=32)")
        return {name: self._axis(name, what, ends) for name, what in self.axes.items()}

    def _axis(self, name: str, what: Any, ends: Ends) -> Axis:
        if isinstance(what, Axis):
            return what
        if isinstance(what, Sequence | np.ndarray) and not isinstance(what, str):
            return Axis.given(name, what)
        count: Any = what  # `spaced` tells what is no count
        return Axis.spaced(name, count, *ends(name), self.spacing or "uniform")


def _integrated(
    source: BSDF | _Named,
    wanted: _Wanted,
    options: Mapping[str, Any],
    settings: Mapping[str, Any],
    progress: Progress,
) -> Iterator[Table]:
    """A model's tables, one a channel, for each piece in turn."""
    plan = wanted.plan
    if all(channel.quantity for channel in plan.channels):
        why = f"layout '{plan.name}' says what its channels hold"
        refuse_ignored(why, {"quantity": settings["quantity"]})
    chosen = {k: v for k, v in settings.items() if v is not None}
    for piece, channel in _slots(plan):
        bsdf = _model(source, plan, piece, options)
        asked = {**chosen, **({"quantity": channel.quantity} if channel.quantity else {})}
        name = asked.setdefault("quantity", "directional-albedo")
        made = quantity_of(name, asked.get("lobe", "all"), asked.get("transport", "energy"))
        axes = wanted.nodes(partial(default_range, bsdf, made))
        with progress.stage(_slot(piece, name), Grid(tuple(axes.values())).size) as advance:
            yield tabulate(bsdf, axes, progress=advance, **asked)


def _domain_of(source: Approximation) -> Ends:
    """The whole domain of a fit's variable; [0, 1] of a coordinate in another view."""
    domain = dict(zip(source.variables, source.domain, strict=True))
    return lambda name: domain.get(name, (0.0, 1.0))


def _model(source: BSDF | _Named, plan: Layout, piece: Piece, options: Mapping[str, Any]) -> BSDF:
    """The model as the consumer evaluates it, but for what was asked for."""
    if isinstance(source, BSDF):
        refuse_ignored("a model that is made already has its options", {"options": options})
        return source
    known = models()[source.name].option_choices()
    chosen = {k: v for k, v in {**plan.options, **piece.options}.items() if k in known}
    chosen.update(options)
    return registered_model(source.name, **chosen)


def _table(source: Any, wanted: _Wanted) -> Table:
    if isinstance(source, Table):
        if not wanted.plan.axes:
            refuse_ignored("a table has its own nodes", {"axes": wanted.axes, "spacing": wanted.spacing})
        for name, count in wanted.axes.items():
            for axis in source.axes:
                if viewed(name, axis.name, axis.nodes) is not None and len(axis) != count:
                    raise EcfitError(f"the table has {len(axis)} nodes of {axis.name}, not {count}")
        return source
    if not isinstance(source, Approximation):
        raise EcfitError("one model makes all channels of a layout: give it alone")
    axes = wanted.nodes(_domain_of(source))
    nodes, order = source.nodes_of({a.name: a.nodes for a in axes.values()}, source.contract.parameters)
    _within(source, nodes)
    shape = tuple(len(a) for a in axes.values())
    values = np.transpose(source.on_grid(nodes), np.argsort(order)).reshape(shape)
    return Table.from_array(values, axes, source.contract, source=source.name)


def _within(source: Approximation, nodes: Sequence[np.ndarray]) -> None:
    """Raises `EcfitError` for nodes outside the domain of a fit, where its values mean nothing."""
    for name, x, (low, high) in zip(source.variables, nodes, source.domain, strict=False):
        slack = 1e-9 * max(1.0, abs(high))
        if x.min() < low - slack or x.max() > high + slack:
            raise EcfitError(
                f"'{source.name}' is made for {name} in [{low:g}, {high:g}], the layout has nodes in "
                f"[{x.min():g}, {x.max():g}]"
            )


def _slots(plan: Layout) -> list[tuple[Piece, Channel]]:
    return [(piece, channel) for piece in plan.pieces for channel in plan.channels]


def _slot(piece: Piece, quantity: str) -> str:
    return " ".join(w for w in (piece.name, quantity) if w)
