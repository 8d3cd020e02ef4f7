"""How far single precision is from the exact value of the same expression, in units of the last place."""

from collections.abc import Mapping

import numpy as np

from ecfit.export.coordinates import Arguments
from ecfit.expressions import Node
from ecfit.expressions.evaluate import NUMPY, evaluate

Points = dict[str, np.ndarray]


def points(taken: Arguments, count: int, seed: int, edges: bool = True) -> Points:
    """Random arguments in the domain, float32, shape (count,), uniform in each argument.

    With `edges`, half of the values lie on the ends or, logarithmically, near the lower one, and all corners
    of the domain come first.
    """
    rng = np.random.default_rng(seed)
    out = {}
    corners = np.array(list(np.ndindex(*[2] * len(taken.names))), dtype=np.float64)
    for i, (name, (low, high)) in enumerate(zip(taken.names, taken.domain, strict=True)):
        even = rng.uniform(low, high, count)
        near = low + (high - low) * 10.0 ** rng.uniform(-9.0, 0.0, count)
        kind = rng.integers(0, 8, count) if edges else np.full(count, 7)
        chosen = np.select([kind == 0, kind == 1, kind < 4], [low, high, near], even)
        if edges:
            chosen[: len(corners)] = low + (high - low) * corners[:, i]
        # Rounding must not leave the domain: its ends may not be single precision numbers.
        out[name] = np.clip(chosen.astype(np.float32), _inward(low, 1.0), _inward(high, -1.0))
    return out


def _inward(end: float, towards: float) -> np.float32:
    rounded = np.float32(end)
    outside = towards * (float(rounded) - end) < 0.0
    return np.nextafter(rounded, np.float32(towards * np.inf)) if outside else rounded


def exact(node: Node, at: Mapping[str, np.ndarray]) -> np.ndarray:
    """The expression at single precision points, with its single precision constants, in double precision."""
    wide = {name: p.astype(np.float64) for name, p in at.items()}
    with np.errstate(all="ignore"):
        found = evaluate([node], wide, NUMPY, lambda c: np.float64(np.float32(c)))[0]
    return np.broadcast_to(found, next(iter(wide.values())).shape)


def ulps(found: np.ndarray, truth: np.ndarray, floor: float = float(np.finfo(np.float32).tiny)) -> np.ndarray:
    """|found - truth| in units of the last place of max(|truth|, floor) in single precision.

    0 where both are equal or NaN; infinite where else one is NaN.

    Args:
        floor: by default the least normal number: what is below has fewer digits, and hardware may flush it
            to 0.
    """
    place = np.spacing(np.maximum(np.abs(truth), floor).astype(np.float32))
    same = (found == truth) | (np.isnan(found) & np.isnan(truth))
    with np.errstate(invalid="ignore"):
        apart = np.abs(found.astype(np.float64) - truth) / place
    return np.where(same, 0.0, np.where(np.isnan(apart), np.inf, apart))
