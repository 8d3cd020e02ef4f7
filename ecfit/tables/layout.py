"""The order of the numbers in a file: which coordinate varies fastest, and which runs backwards."""

import math
from collections.abc import Sequence
from itertools import permutations

import numpy as np

from ecfit.coordinates import Axis
from ecfit.errors import EcfitError


def arranged(array: np.ndarray, axes: Sequence[Axis], order: Sequence[str] | None, what: str) -> np.ndarray:
    """The numbers of a file as an array with one dimension an axis, in the order of `axes`.

    Args:
        array: of any number of dimensions, its numbers in reading order (row by row).
        axes: the axes of the table.
        order: names of the axes, the one that varies fastest last; by default the order of `axes`. "-mu":
            stored from the last node of mu to the first.
        what: the file, for messages.

    A file may join neighbouring axes (a list; an image of slices), but must keep the ends of its rows: raises
    `EcfitError` where a row would end inside another axis, which is what a transposed file looks like.
    """
    names, backwards = _parsed(axes, order)
    counts = {a.name: len(a) for a in axes}
    if not _fits(array.shape, [counts[n] for n in names]):
        wanted = " x ".join(f"{n} = {counts[n]}" for n in names)
        # Five axes have 120 orders; more are not worth a search.
        others = permutations(counts) if len(counts) <= 5 else ()
        other = next((o for o in others if _fits(array.shape, [counts[n] for n in o])), None)
        hint = f"; order = {list(other)} would fit" if other else ": check the counts of the axes and order"
        raise EcfitError(f"{what} holds {_shape(array.shape)} numbers, expected {wanted}{hint}")
    table = array.reshape([counts[n] for n in names])
    for name in backwards:
        table = np.flip(table, names.index(name))
    return np.transpose(table, [names.index(a.name) for a in axes])


def _parsed(axes: Sequence[Axis], order: Sequence[str] | None) -> tuple[list[str], list[str]]:
    """Names from slowest to fastest, and those that run backwards."""
    valid = [a.name for a in axes]
    if order is None:
        return valid, []
    if isinstance(order, str) or not all(isinstance(n, str) for n in order):
        raise EcfitError(f"order must be a list of names such as {valid}, got {order!r}")
    names = [n.removeprefix("-") for n in order]
    if sorted(names) != sorted(valid):
        raise EcfitError(f"order must name each axis once ({', '.join(valid)}), got {', '.join(order)}")
    return names, [n.removeprefix("-") for n in order if n.startswith("-")]


def _ends(shape: Sequence[int]) -> set[int]:
    """Numbers after which a run over the last dimension, the last two, ... is complete."""
    return {math.prod(shape[i:]) for i in range(len(shape) + 1)}


def _fits(shape: Sequence[int], counts: Sequence[int]) -> bool:
    return math.prod(shape) == math.prod(counts) and _ends(shape) <= _ends(counts)


def _shape(shape: Sequence[int]) -> str:
    return " x ".join(map(str, shape)) or "no list of"
