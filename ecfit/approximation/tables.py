"""Bilinear tables as approximations: what renderers sample where they have no formula."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ecfit.approximation.approximation import Approximation
from ecfit.bsdf import BSDF, as_model
from ecfit.coordinates import Axis, Grid, viewed
from ecfit.errors import EcfitError, unknown
from ecfit.quantities import quantity as make_quantity
from ecfit.tables import Request
from ecfit.tables.tabulate import default_range


def lookup_table(
    model: BSDF | type[BSDF] | str,
    counts: Mapping[str, int],
    *,
    through: Mapping[str, str] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    quantity: str = "directional-albedo",
    lobe: str = "all",
    transport: str = "energy",
    tolerance: float = 1e-7,
    quantity_options: Mapping[str, int] | None = None,
) -> Approximation:
    """A table, computed and read with multilinear interpolation: the competitor of a fit.

    Args:
        model: a BSDF or the name of a registered one.
        counts: coordinate -> number of nodes, both ends included: {"r": 32, "mu": 32}.
        through: coordinate -> map, where nodes are equidistant in t and the coordinate is map(t):
            {"mu": "square"} has mu = t^2, {"F0": "fourth-power"} is uniform in F0^(1/4).
        ranges: coordinate -> (low, high); the full range by default. Beyond it the nearest value holds.
        quantity, lobe, transport, tolerance, quantity_options: as in `ecfit.tabulate`.

    Returns an `Approximation` named after its size and spacing: "table-32x32-mu-square". Raises `EcfitError`
    for unknown names and ranges outside the model's domain.
    """
    bsdf = as_model(model)
    quantity_ = make_quantity(quantity, lobe, transport, **(quantity_options or {}))
    given = dict(ranges or {})
    for name in given:
        if name not in counts:
            raise unknown("coordinate", name, counts)
    ends = {name: default_range(bsdf, quantity_, name, given.get(name, (None, None))) for name in counts}
    axes = _axes(counts, through or {}, ends)
    return as_lookup(
        Request.make(bsdf, axes, quantity, lobe, transport, tolerance, quantity_options).compute()
    )


def lookup_request(like: Request, counts: Mapping[str, int], through: Mapping[str, str]) -> Request:
    """The small table that stands for the same function as the table `like`, over the same domain.

    `counts` and `through` are those of `lookup_table`; coordinates may be in another view than `like`'s.
    Raises `EcfitError` unless they correspond to the axes of `like` one to one.
    """
    ends, used = {}, set()
    for name in counts:
        axis, ends[name] = _range(name, like.grid.axes)
        used.add(axis)
    if len(counts) != len(like.grid.axes) or used != set(like.grid.names):
        raise EcfitError(
            f"a look-up of {', '.join(counts)} cannot stand for a table of {', '.join(like.grid.names)}"
        )
    axes = _axes(counts, through, ends)
    return replace(like, grid=Grid(tuple(axes.values())))


def as_lookup(table: Any) -> Approximation:
    """A computed table as an approximation, named after its size and spacing."""
    return Approximation.lookup(table, lookup_name(table.grid))


def lookup_name(grid: Grid) -> str:
    """ "table-32x32-mu-square" for 32 x 32 nodes, those of mu through the map "square"."""
    size = "x".join(map(str, grid.shape))
    maps = [f"{a.name}-{a.through}" for a in grid.axes if a.through != "identity"]
    return "-".join(["table", size, *maps])


def _axes(
    counts: Mapping[str, int], through: Mapping[str, str], ends: Mapping[str, tuple[float, float]]
) -> dict[str, Axis]:
    for name in through:
        if name not in counts:
            raise unknown("coordinate", name, counts)
    return {
        name: Axis.spaced(name, count, *ends[name], through=through.get(name, "identity"))
        for name, count in counts.items()
    }


def _range(name: str, axes: Sequence[Axis]) -> tuple[str, tuple[float, float]]:
    """The axis that a coordinate in any view stands for, and the axis's range in that view."""
    for axis in axes:
        low, high = (viewed(name, axis.name, end) for end in (axis.low, axis.high))
        if low is not None and high is not None:
            return axis.name, (float(low), float(high))
    raise EcfitError(f"no axis stands for '{name}': expected one of {', '.join(a.name for a in axes)}")
