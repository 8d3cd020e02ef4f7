"""Candidate terms of a structured form: all products of powers of features within bounds."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ecfit.errors import EcfitError
from ecfit.forms.features import FEATURES, feature
from ecfit.forms.heads import Head
from ecfit.forms.structured import Structure

# More candidates than this make a step of the selection take seconds.
MOST = 20_000


@dataclass(frozen=True)
class Powers:
    """Bounds of the terms of one polynomial.

    Attributes:
        highest: feature -> highest exponent.
        step: multiples of this (0.5: half-integer powers) for features of the corner, integers for others.
        lowest_order, highest_order: range of the order at the corner.
        factors: at most this many different features in one term.
        total: highest sum of all exponents, weighted by 1; 64 for no bound.
    """

    highest: Mapping[str, float]
    step: float = 1.0
    lowest_order: float = 0.0
    highest_order: float = 64.0
    factors: int = 3
    total: float = 64.0

    def rows(self, features: Sequence[str]) -> np.ndarray:
        """Exponents, shape (terms, features), lowest order first. Raises `EcfitError` for too many."""
        for name, top in self.highest.items():
            if name not in features:
                raise EcfitError(
                    f"highest names '{name}', which is not among the features {', '.join(features)}"
                )
            if isinstance(top, bool) or not isinstance(top, int | float) or not 0.0 <= top <= 64.0:
                raise EcfitError(f"the highest exponent of {name} must be in 0..64, got {top!r}")
        if not 0.25 <= self.step <= 64.0:
            raise EcfitError(f"step must be in 0.25..64, got {self.step!r}")
        for name in ("lowest_order", "highest_order", "factors", "total"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise EcfitError(f"{name} must be a number, got {value!r}")
        choices = []
        for name in features:
            top = float(self.highest.get(name, 0.0))
            step = self.step if feature(name).order == 1.0 else 1.0
            choices.append(np.arange(0.0, top + 1e-9, step))
        size = math.prod(len(c) for c in choices)
        if size > 100 * MOST:
            raise EcfitError(f"{size} candidate terms: lower the exponents of the features")
        orders = np.array([FEATURES[f].order for f in features])
        rows = np.array(list(itertools.product(*choices)))
        order = rows @ orders
        keep = (order >= self.lowest_order - 1e-9) & (order <= self.highest_order + 1e-9)
        keep &= (rows > 0.0).sum(axis=1) <= self.factors
        keep &= rows.sum(axis=1) <= self.total + 1e-9
        rows, order = rows[keep], order[keep]
        if not 1 <= len(rows) <= MOST:
            raise EcfitError(f"{len(rows)} candidate terms within the bounds: expected 1..{MOST}")
        return rows[np.lexsort((*rows.T[::-1], order))]


def candidates(
    head: Head, features: Sequence[str], numerators: Sequence[Powers], denominator: Powers
) -> Structure:
    """All candidate terms as one structure. Raises `EcfitError` for bounds without terms."""
    return Structure(
        head, tuple(features), tuple(p.rows(features) for p in numerators), denominator.rows(features)
    )


def chosen(whole: Structure, support: Sequence[Sequence[int]], leading: int) -> Structure:
    """The structure of some of the candidates; Q's `leading` one first."""
    *numerators, denominator = support
    return Structure(
        whole.head,
        whole.features,
        tuple(n[list(s)] for n, s in zip(whole.numerators, numerators, strict=True)),
        whole.denominator[[leading, *denominator]],
    ).without_unused()
