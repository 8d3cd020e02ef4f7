"""From a model to a table: resolve the axes, integrate block by block, refine each entry."""

import hashlib
import inspect
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
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
NUMERICS_VERSION = 1

# BSDF values held at once (4 MB an intermediate array): within the caches, whatever the grid.
_BLOCK_VALUES = 2**19


def default_range(
    model: BSDF,
    quantity_: Quantity,
    name: str,
    given: tuple[float | None, float | None] = (None, None),
) -> tuple[float, float]:
    """The full range of a coordinate: [0, 1] for mu, the parameter's range in that view otherwise.

    `given` ends replace those of the full range. Raises `EcfitError` where an end is then infinite.
    """
    parameter, map_ = parameter_map(model, quantity_, name)
    if parameter in quantity_.coordinates:
        ends = [0.0, 1.0]
    else:
        ends = [float(map_.inverse(v)) for v in model.parameter_ranges()[parameter]]
    low, high = (full if end is None else end for full, end in zip(ends, given, strict=True))
    if not np.isfinite(low) or not np.isfinite(high):
        raise EcfitError(f"axis '{name}' has no finite full range [{low:g}, {high:g}]: give low and high")
    return low, high


@dataclass(frozen=True)
class Request:
    """A table to be computed: everything that determines its values. Validates on construction."""

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
                lowest, highest = 0.0, 1.0
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
        for name, used in (("quantity", self.quantity.coordinates),):
            if not used and "mu" in self.grid.names:
                raise EcfitError(f"the {name} '{self.quantity_name}' does not depend on mu")

    @classmethod
    def make(
        cls,
        model: BSDF | type[BSDF] | str,
        axes: Mapping[str, object],
        quantity_name: str = "directional-albedo",
        lobe: str = "all",
        transport: str = "energy",
        tolerance: float = 1e-7,
    ) -> "Request":
        """Resolve names and axis counts; see `tabulate` for the arguments."""
        bsdf = as_model(model)
        quantity_ = quantity(quantity_name, lobe, transport)
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
        fixed = [n for n in self.model.active_parameters() if n not in axes]
        return Contract(
            model=name_of(self.model),
            options=self.model.options(),
            parameters={n: float(getattr(self.model, n)) for n in fixed},
            quantity=self.quantity_name,
            lobe=self.quantity.lobe,
            transport=self.quantity.transport,
            sampling="clamped" if any(a.clamped for a in self.grid.axes) else "true",
        )

    @property
    def key(self) -> str:
        """Content hash of the request: equal keys mean equal tables."""
        text = {
            "numerics": NUMERICS_VERSION,
            "contract": self.contract.to_dict(),
            "tolerance": self.tolerance,
            "source": _source_hash(type(self.model)),
        }
        digest = hashlib.sha256(json.dumps(text, sort_keys=True).encode())
        for axis in self.grid.axes:
            digest.update(repr((axis.name, axis.spacing, axis.through, axis.low, axis.high)).encode())
            digest.update(axis.nodes.tobytes())
            digest.update(axis.nominal.tobytes())
        return digest.hexdigest()[:16]

    def compute(self, progress: Callable[[int], None] | None = None) -> Table:
        """Integrate every entry until its error estimate meets the tolerance."""
        names = self.grid.names
        maps = {n: parameter_map(self.model, self.quantity, n) for n in names}
        nodes = self.quantity.nodes(self.model)

        def evaluate(level: int, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            points = self.grid.nodes_at(index)
            arrays = [np.asarray(maps[n][1].forward(points[n])) for n in names]
            parameters = tuple(maps[n][0] for n in names)
            block = max(1, min(_BLOCK_VALUES // nodes[level], 1 << (index.size - 1).bit_length()))
            return in_blocks(
                lambda *a: _evaluate(self.model, self.quantity, parameters, level, a), arrays, block
            )

        confirm = self.quantity.confirm(self.model)
        done = refine(evaluate, self.grid.size, len(nodes), self.tolerance, confirm, progress)
        shape = self.grid.shape
        provenance = {**versions(), "key": self.key}
        return Table(
            done.values.reshape(shape),
            done.errors.reshape(shape),
            done.status.reshape(shape),
            self.grid.axes,
            self.contract,
            float(self.tolerance),
            provenance,
        )


@eqx.filter_jit
def _evaluate(
    model: BSDF, quantity_: Quantity, parameters: tuple[str, ...], level: int, arrays: tuple[Array, ...]
) -> Estimate:
    def one(*values: Array) -> Estimate:
        point = dict(zip(parameters, values, strict=True))
        mu = point.pop("mu", jnp.asarray(1.0))
        return quantity_.estimate(model.with_parameters(point), mu, level)

    return jax.vmap(one)(*arrays)


def _source_hash(cls: type) -> str:
    """Hash of the file that defines a user's model; ecfit's own are covered by NUMERICS_VERSION."""
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


def versions() -> dict[str, str]:
    """Versions of what computes numbers."""
    from importlib.metadata import version

    return {name: version(name) for name in ("ecfit", "jax", "numpy", "optimistix")}


def tabulate(
    model: BSDF | type[BSDF] | str,
    axes: Mapping[str, object],
    *,
    quantity: str = "directional-albedo",
    lobe: str = "all",
    transport: str = "energy",
    tolerance: float = 1e-7,
    progress: Callable[[int], None] | None = None,
) -> Table:
    """Integrate a quantity of a model on a grid.

    Args:
        model: a BSDF or the name of a registered one.
        axes: name -> number of nodes (uniform over the full range), increasing nodes, or an `Axis`. Names
            are mu and the model's parameters in any view; the table's dimensions keep their order.
        quantity: "directional-albedo" or "average-albedo".
        lobe: "all", "reflection" or "transmission".
        transport: "energy" or "radiance".
        tolerance: absolute error to reach in every entry.
        progress: called with the number of entries that finished since the last call.

    Returns a `Table`; entries whose estimate stays above the tolerance carry that in their status.
    Raises `EcfitError` for unknown names and axes outside the model's domain.
    """
    return Request.make(model, axes, quantity, lobe, transport, tolerance).compute(progress)
