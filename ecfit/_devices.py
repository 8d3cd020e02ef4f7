"""Rows of entries over JAX's devices: each runs the same program on its share, and nothing is exchanged."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ecfit._jax import jax

Mesh = jax.sharding.Mesh
_ROWS = "rows"


def row_mesh() -> Mesh | None:
    """This process's devices of the default backend in a line; None for one, which needs no distribution.

    A default device that the user has set (`jax.default_device`) is the only one that is used.
    """
    devices = jax.local_devices()
    chosen = jax.config.jax_default_device  # pyright: ignore[reportAttributeAccessIssue]
    if len(devices) < 2 or chosen is not None:
        return None
    return Mesh(np.array(devices), (_ROWS,))


def device_count(mesh: Mesh | None) -> int:
    """Devices that share the rows: numbers of rows have to be multiples of it."""
    return 1 if mesh is None else mesh.size


def over_rows(function: Callable[..., Any], mesh: Mesh | None) -> Callable[..., Any]:
    """`function(whole, *arrays)`, whose arrays and results have rows first, with the rows distributed.

    Every device has all of `whole`, and of anything else that the function refers to.
    """
    if mesh is None:
        return function

    def distributed(whole: Any, *arrays: Any) -> Any:
        every, rows = jax.sharding.PartitionSpec(), jax.sharding.PartitionSpec(_ROWS)
        specs = (every, *[rows] * len(arrays))
        # Not checked which values differ between devices: a user's loop may start from a constant.
        shares = jax.shard_map(function, mesh=mesh, in_specs=specs, out_specs=rows, check_vma=False)
        return shares(whole, *arrays)

    return distributed
