"""An approximation of E as a renderer has it: exported code, or the nodes of a table, in single precision."""

from functools import cache
from typing import Any

import numpy as np

from ecfit.approximation import Approximation, Lookup
from ecfit.coordinates import MAPS, resolve
from ecfit.export import code
from ecfit.rendering.sphere import AlbedoCode


def arguments(approximation: Approximation, r: float, ior: float | None) -> dict[str, float]:
    """The coordinates other than mu of an approximation at one r and, where it has a second one, ior."""
    others = [v for v in approximation.variables if v != "mu"]
    given: dict[str, Any] = {"r": r} if len(others) == 1 else {"r": r, "ior": ior}
    return {name: float(value) for name, value in resolve(others, given).items()}


@cache  # of the few approximations of a config, for its many spheres
def _text(approximation: Approximation) -> str:
    return code(approximation, "python", name="E")


def albedo_code(approximation: Approximation, r: float, ior: float | None) -> AlbedoCode:
    """An approximation of mu, roughness and perhaps ior at one r and ior, as plain data."""
    fixed = arguments(approximation, r, ior)
    formula = approximation.formula
    if not isinstance(formula, Lookup):
        return AlbedoCode(approximation.name, _text(approximation), fixed)
    place = approximation.variables.index("mu")
    ends, map_ = formula.ranges[place], MAPS[formula.through[place]]
    low, high = (float(map_.inverse(end)) for end in ends)
    nodes = map_.forward(np.linspace(low, high, formula.grid.shape[place]))
    values = np.asarray(approximation(mu=nodes, **fixed))
    return AlbedoCode(approximation.name, nodes=tuple(nodes.tolist()), values=tuple(values.tolist()))
