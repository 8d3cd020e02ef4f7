"""Fits that should not fall, or not rise, along a coordinate: a hinge penalty on a grid over the domain."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ecfit.errors import EcfitError
from ecfit.fitting.descent import Descent, Pairs, Rows, Solved
from ecfit.fitting.weights import axis_of
from ecfit.forms import Structure
from ecfit.tables import Table

# Nodes an axis of the grid by the number of axes, clustered towards the ends, more so towards 0: the corner.
_NODES = {1: 129, 2: 33, 3: 15}
# A table contradicts a direction if its values go this far against it, and less than this part of that along.
_AGAINST, _NOISE = 1e-3, 1e-2
# Weights of the penalty, in turn until no difference is wrong by more than _ALLOWED: each descent starts
# from the one before, as a heavy penalty at once would hold a descent on the edge.
_WEIGHTS = (10.0, 100.0, 1000.0, 10000.0)
_ALLOWED = 1e-7
# A difference wrong by more than this after the last descent is no monotone fit: it is not called converged.
_HELD = 1e-5


def directions(given: Any, axes: Sequence[str]) -> dict[str, int]:
    """Axis -> 1 or -1, from coordinates in any view (all views grow together).

    Raises `EcfitError` for unknown coordinates and directions, and two views of one axis that contradict.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise EcfitError(f"monotone maps coordinates to 1 or -1, such as {{'mu': 1}}, got {given!r}")
    out: dict[str, int] = {}
    for coordinate, sign in given.items():
        if isinstance(sign, bool) or sign not in (1, -1):
            raise EcfitError(
                f"monotone: {coordinate} needs 1 (does not fall) or -1 (does not rise), got {sign!r}"
            )
        axis = axis_of(coordinate, axes)
        if out.setdefault(axis, int(sign)) != sign:
            raise EcfitError(f"monotone contradicts itself: '{coordinate}' is another view of '{axis}'")
    return out


def check_truth(given: Any, table: Table) -> None:
    """Raise `EcfitError` where a table does all but nothing of what `directions` ask of its fit."""
    for axis, sign in directions(given, table.names).items():
        steps = sign * np.diff(table.values, axis=table.names.index(axis))
        # Of the line along the axis that goes furthest.
        along, against = (np.maximum(s, 0.0).sum(axis=table.names.index(axis)).max() for s in (steps, -steps))
        if against > _AGAINST and along < _NOISE * against:
            verb, other = ("fall", "rise") if sign == 1 else ("rise", "fall")
            raise EcfitError(
                f"monotone: the table's values {verb} along {axis}, and hardly {other} anywhere: "
                f"ask for {{'{axis}': {-sign}}}, or leave it out"
            )


def pairs_of(
    given: Mapping[str, int], structure: Structure, domain: Mapping[str, tuple[float, float]]
) -> Pairs:
    """Neighbours on a grid over the domain along each monotone coordinate, in growing order of the value."""
    t = 0.5 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, _NODES.get(len(domain), 9))))
    axes = [
        low + (high - low) * (t * t if name in ("mu", "alpha") else t) for name, (low, high) in domain.items()
    ]
    mesh = np.meshgrid(*axes, indexing="ij")
    index = np.arange(mesh[0].size).reshape(mesh[0].shape)
    points = {n: m.ravel() for n, m in zip(domain, mesh, strict=True)}
    low, high = [], []
    for name, sign in directions(given, tuple(domain)).items():
        v = list(domain).index(name)
        first, second = (np.delete(index, end, axis=v).ravel() for end in (-1, 0))
        low.append(first if sign == 1 else second)
        high.append(second if sign == 1 else first)
    pairs = np.array([np.concatenate(low), np.concatenate(high)])
    if {"alpha", "mu"} <= set(domain):  # the corner has no one value
        regular = points["alpha"] + points["mu"] > 0.0
        pairs = pairs[:, regular[pairs].all(axis=0)]
    return Pairs(
        Rows(structure.factors(points), structure.data(points)), structure.columns(points), pairs[0], pairs[1]
    )


def held(
    given: Mapping[str, int],
    descent: Descent,
    structure: Structure,
    domain: Mapping[str, tuple[float, float]],
    start: np.ndarray,
    solve: Callable[[np.ndarray], Solved],
) -> Solved:
    """What `solve` finds from `start` with the penalty on `descent`, heavier until it holds.

    Not converged where it does not hold in the end.
    """
    support = [list(range(len(n))) for n in structure.numerators]
    support.append(list(range(1, len(structure.denominator))))
    descent.pairs, steps = pairs_of(given, structure, domain), 0
    solved, least = None, -np.inf
    for weight in _WEIGHTS:
        descent.pair_weight = weight
        solved = solve(start)
        steps, start = steps + solved.steps, solved.coefficients
        least = descent.least_difference(support, 0, start)
        if least >= -_ALLOWED:
            break
    assert solved is not None
    return solved._replace(steps=steps, converged=solved.converged and least >= -_HELD)
