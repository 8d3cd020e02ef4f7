"""From a model to a table: resolve the axes, integrate block by block, refine each entry."""

import hashlib
import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import equinox as eqx
import numpy as np

from ecfit._devices import Mesh, device_count, over_rows, row_mesh
from ecfit._jax import jax, jnp
from ecfit._versions import versions
from ecfit.bsdf import BSDF, as_model
from ecfit.bsdf.registry import name_of
from ecfit.contract import Contract
from ecfit.coordinates import Axis, Grid
from ecfit.errors import EcfitError
from ecfit.quadrature import Estimate
from ecfit.quadrature.refine import in_blocks, refine
from ecfit.quantities import Quantity, parameter_map, quantity
from ecfit.tables.table import Table

Array = jax.Array

# Raise this when a change moves the numbers of tables: it is part of every table's key.
NUMERICS_VERSION = 2

# BSDF values held at once by a device (4 MB an intermediate array): within the caches, whatever the grid.
_BLOCK_VALUES = 2**19
# The same where one row alone has more: longer rows are cut (64 MB an intermediate array). Cutting computes
# the geometry once a piece, so it should be rare.
_ROW_VALUES = 2**23


def default_range(
    model: BSDF,
    quantity_: Quantity,
    name: str,
    given: tuple[float | None, float | None] = (None, None),
) -> tuple[float, float]:
    """The full range of a coordinate: the quantity's or the parameter's, in that view.

    `given` ends replace those of the full range. Raises `EcfitError` where an end is then infinite.
    """
    parameter, map_ = parameter_map(model, quantity_, name)
    if parameter in quantity_.coordinates:
        ends = list(quantity_.range_of(parameter))
    else:
        ends = [float(map_.inverse(v)) for v in model.parameter_ranges()[parameter]]
    low, high = (full if end is None else end for full, end in zip(ends, given, strict=True))
    if not np.isfinite(low) or not np.isfinite(high):
        raise EcfitError(f"axis '{name}' has no finite full range [{low:g}, {high:g}]: give low and high")
    return low, high


@dataclass(frozen=True)
class Request:
    """A table to be computed: everything that determines its values. Validates on construction.

    Raises `EcfitError` for a tolerance outside (0, 1), axes outside the model's domain, and ones that the
    quantity lacks or ignores.
    """

    model: BSDF
    grid: Grid
    quantity: Quantity
    quantity_name: str
    tolerance: float

    def __post_init__(self) -> None:
        if not (isinstance(self.tolerance, int | float) and 0.0 < self.tolerance < 1.0):
            raise EcfitError(f"tolerance must be in (0, 1), got {self.tolerance!r}")
        seen: dict[str, str] = {}
        for axis in self.grid.axes:
            parameter, map_ = parameter_map(self.model, self.quantity, axis.name)
            if parameter in seen:
                raise EcfitError(f"axes '{seen[parameter]}' and '{axis.name}' are the same coordinate")
            seen[parameter] = axis.name
            low, high = float(axis.nodes[0]), float(axis.nodes[-1])
            if low < map_.low or high > map_.high:
                raise EcfitError(f"axis '{axis.name}' must lie in [{map_.low:g}, {map_.high:g}]")
            if parameter in self.quantity.coordinates:
                lowest, highest = self.quantity.range_of(parameter)
            else:
                lowest, highest = self.model.parameter_ranges()[parameter]
            if not (lowest <= map_.forward(low) and map_.forward(high) <= highest):
                raise EcfitError(
                    f"axis '{axis.name}' spans [{low:g}, {high:g}], outside the model's domain "
                    f"{parameter} in [{lowest:g}, {highest:g}]"
                )
        for name in self.quantity.coordinates:
            if name not in seen:
                raise EcfitError(f"the quantity '{self.quantity_name}' needs the axis '{name}'")
        if "mu" not in self.quantity.coordinates and "mu" in self.grid.names:
            raise EcfitError(f"the quantity '{self.quantity_name}' does not depend on mu")

    @classmethod
    def make(
        cls,
        model: BSDF | type[BSDF] | str,
        axes: Mapping[str, object],
        quantity_name: str = "directional-albedo",
        lobe: str = "all",
        transport: str = "energy",
        tolerance: float = 1e-7,
        quantity_options: Mapping[str, int] | None = None,
    ) -> "Request":
        """Resolve names and axis counts; arguments and errors (`EcfitError`) are those of `tabulate`."""
        bsdf = as_model(model)
        quantity_ = quantity(quantity_name, lobe, transport, **(quantity_options or {}))
        if not isinstance(axes, Mapping) or not axes:
            raise EcfitError("axes must be a mapping such as {'r': 64, 'mu': 64}")
        made = []
        for name, what in axes.items():
            if isinstance(what, Axis):
                if what.name != name:
                    raise EcfitError(f"axis '{what.name}' given under the name '{name}'")
                made.append(what)
            elif isinstance(what, int | np.integer) and not isinstance(what, bool):
                low, high = default_range(bsdf, quantity_, name)
                made.append(Axis.spaced(name, int(what), low, high))
            else:
                made.append(Axis.given(name, what))  # type: ignore[arg-type]
        return cls(bsdf, Grid(tuple(made)), quantity_, quantity_name, tolerance)

    @property
    def contract(self) -> Contract:
        """The conventions of the table."""
        axes = {parameter_map(self.model, self.quantity, a.name)[0] for a in self.grid.axes}
        fixed = [n for n in self.quantity.parameters(self.model) if n not in axes]
        return Contract(
            model=name_of(self.model),
            options=self.model.options(),
            parameters={n: float(self.model.parameter_value(n)) for n in fixed},
            quantity=self.quantity_name,
            lobe=self.quantity.lobe,
            transport=self.quantity.transport,
            quantity_options=self.quantity.options(),
            sampling="clamped" if any(a.clamped for a in self.grid.axes) else "true",
        )

    @property
    def key(self) -> str:
        """Content hash of the request: equal keys mean equal tables."""
        text = {
            "numerics": NUMERICS_VERSION,
            "contract": self.contract.to_dict(),
            "tolerance": self.tolerance,
            "source": source_hash(type(self.model)),
        }
        digest = hashlib.sha256(json.dumps(text, sort_keys=True).encode())
        for axis in self.grid.axes:
            digest.update(axis.fingerprint)
        return digest.hexdigest()[:16]

    def compute(self, progress: Callable[[int], None] | None = None) -> Table:
        """Integrate every entry until its error estimate meets the tolerance.

        Entries that differ only in a parameter of the Fresnel factor form rows, which share the geometry.
        """
        axes = list(self.grid.axes)
        maps = {a.name: parameter_map(self.model, self.quantity, a.name) for a in axes}
        shared = [a for a in axes if maps[a.name][0] in self.model.fresnel_parameters]
        inner = max(shared, key=len, default=None)
        outer = [a for a in axes if a is not inner]
        outer_names = tuple(maps[a.name][0] for a in outer)
        outer_nodes = [np.asarray(maps[a.name][1].forward(a.nodes)) for a in outer]
        outer_shape = tuple(len(a) for a in outer)
        if inner is None:
            inner_name, inner_nodes = None, np.zeros(1)
        else:
            inner_name = maps[inner.name][0]
            inner_nodes = np.asarray(maps[inner.name][1].forward(inner.nodes))
        width = inner_nodes.size

        def gather(rows: np.ndarray) -> list[np.ndarray]:
            index = np.unravel_index(rows, outer_shape) if outer else ()
            return [n[i] for n, i in zip(outer_nodes, index, strict=True)]

        evaluate = evaluator(self.model, self.quantity, outer_names, gather, inner_name, inner_nodes)
        confirm = self.quantity.confirm(self.model)
        rows = int(np.prod(outer_shape))
        levels = len(self.quantity.nodes(self.model))
        done = refine(evaluate, (rows, width), levels, self.tolerance, confirm, progress)

        def in_order(values: np.ndarray) -> np.ndarray:
            """From rows to the dimensions of the grid."""
            if inner is None:
                return values.reshape(outer_shape)
            return np.moveaxis(values.reshape(*outer_shape, width), -1, axes.index(inner)).copy()

        values = within_bounds(self.model, self.quantity, done.values, done.errors)
        return Table(
            in_order(values),
            in_order(done.errors),
            in_order(done.status),
            self.grid.axes,
            self.contract,
            float(self.tolerance),
            {**versions(), "key": self.key},
        )


def evaluator(
    model: BSDF,
    quantity_: Quantity,
    names: tuple[str, ...],
    gather: Callable[[np.ndarray], Sequence[np.ndarray]],
    inner: str | None,
    inner_nodes: np.ndarray,
) -> Callable[[int, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """What `refine` calls: (level, row indices) -> values and error estimates, block by block.

    The memory that it takes beside its results depends neither on the number of rows nor on their length.
    Where JAX has several devices each takes a part of every block.

    Args:
        names: parameters (and mu) that differ from row to row; `gather` gives their values at row indices.
        inner: a parameter of the Fresnel factor that takes `inner_nodes` within a row, or None.
    """
    nodes, width = quantity_.nodes(model), inner_nodes.size
    mesh = row_mesh()
    devices = device_count(mesh)

    def evaluate(level: int, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        arrays = list(gather(rows)) or [np.zeros(rows.size)]
        pieces = _pieces(inner_nodes, max(1, _ROW_VALUES // nodes[level]))
        most = 1 << (-(-rows.size // devices) - 1).bit_length()
        block = devices * max(1, min(_BLOCK_VALUES // (nodes[level] * pieces[0].size), most))

        def function(*a: np.ndarray) -> list[np.ndarray]:
            found = [_evaluate(model, quantity_, names, inner, level, a, piece, mesh) for piece in pieces]
            return [np.concatenate(parts, axis=1)[:, :width] for parts in zip(*found, strict=True)]

        return in_blocks(function, arrays, block, width)

    return evaluate


def _pieces(nodes: np.ndarray, most: int) -> list[np.ndarray]:
    """Pieces of one length, `most` or less; the last is filled up with its last node."""
    count = -(-nodes.size // most)
    length = -(-nodes.size // count)
    return np.split(np.pad(nodes, (0, count * length - nodes.size), mode="edge"), count)


def within_bounds(model: BSDF, quantity_: Quantity, values: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Values of a quantity that is known to lie in [0, 1]: an end within the estimate is nearer to it."""
    if not quantity_.bounded(model):
        return values
    nearest = np.clip(values, 0.0, 1.0)
    return np.where(np.abs(nearest - values) <= errors, nearest, values)


@eqx.filter_jit
def _evaluate(
    model: BSDF,
    quantity_: Quantity,
    outer: tuple[str, ...],
    inner: str | None,
    level: int,
    arrays: tuple[np.ndarray, ...],
    shared: np.ndarray,
    mesh: Mesh | None,
) -> Estimate:
    """Estimates of shape (rows, entries a row), the rows distributed over `mesh`."""

    def one(value: Array, *values: Array) -> Estimate:
        point = dict(zip(outer, values, strict=False))
        if inner is not None:
            point[inner] = value
        own = {n: point.pop(n) for n in quantity_.coordinates if n in point}
        return quantity_.estimate_at(model.with_parameters(point), own, level)

    # The inner map leaves the geometry unbatched: it is computed once a row.
    row = jax.vmap(one, (0, *[None] * len(arrays)))
    rows = over_rows(jax.vmap(row, (None, *[0] * len(arrays))), mesh)
    return rows(jnp.asarray(shared), *map(jnp.asarray, arrays))


def source_hash(cls: Any) -> str:
    """Hash of the file of a user's class or function; ecfit's own are covered by NUMERICS_VERSION."""
    if cls.__module__.startswith("ecfit."):
        return "ecfit"
    try:
        source = Path(inspect.getfile(cls)).read_bytes()
    except (OSError, TypeError):
        try:
            source = inspect.getsource(cls).encode()
        except (OSError, TypeError):  # typed at a prompt: no source to be had
            return "unknown"
    return hashlib.sha256(source).hexdigest()[:16]


def tabulate(
    model: BSDF | type[BSDF] | str,
    axes: Mapping[str, object],
    *,
    quantity: str = "directional-albedo",
    lobe: str = "all",
    transport: str = "energy",
    tolerance: float = 1e-7,
    quantity_options: Mapping[str, int] | None = None,
    progress: Callable[[int], None] | None = None,
) -> Table:
    """Integrate a quantity of a model on a grid.

    Args:
        model: a BSDF or the name of a registered one.
        axes: name -> number of nodes (uniform over the full range), increasing nodes, or an `Axis`. Names
            are mu and the model's parameters in any view; the table's dimensions keep their order.
        quantity: a name of `ecfit.contract.QUANTITIES`: "directional-albedo", "average-albedo", ...
        lobe: "all", "reflection" or "transmission".
        transport: "energy" or "radiance".
        tolerance: absolute error to reach in every entry.
        quantity_options: settings of the quantity, such as {"exponent": 6} for "schlick-b".
        progress: called with the number of entries that finished since the last call.

    Returns a `Table`; entries whose estimate stays above the tolerance carry that in their status.
    Raises `EcfitError` for unknown names and axes outside the model's domain.
    """
    request = Request.make(model, axes, quantity, lobe, transport, tolerance, quantity_options)
    return request.compute(progress)
