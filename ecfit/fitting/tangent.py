"""The linear least-squares problem that touches a fit: which terms to exchange is decided there.

About its coefficients, a form is linear in those of all candidate terms. In that problem the best exchange
of a term is known at once (`pivots.Pivots`), so that thousands of supports are compared in the time of one
descent; the best of them are then fitted.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ecfit.fitting.descent import Descent
from ecfit.fitting.pivots import Pivots

# Columns looked at: those in the form and the most promising others. Sweeps take the square of it.
_COLUMNS = 240
# Exchanges after each random change, and the means of how many terms it takes out (geometric), of the rank
# among the least missed of what goes (in parts of the terms) and of the rank by gain of what comes.
_EXCHANGES = 12
_OUT, _RANK_OUT, _RANK_IN = 0.4, 0.3, 2.0
_MOST_OUT = 5
# Columns of the normal equations are of length 1: this ridge is far below any that matters.
_RIDGE = 1e-13


class Proposal(NamedTuple):
    """A support, its coefficients in the tangent, and the weighted RMS residual that it predicts."""

    support: list[list[int]]
    coefficients: np.ndarray
    rms: float


class Tangent:
    """The linear problem about a fit.

    Args:
        descent: candidates and target.
        support, leading, coefficients: the fit.
    """

    def __init__(
        self, descent: Descent, support: Sequence[Sequence[int]], leading: int, coefficients: np.ndarray
    ) -> None:
        chosen = [list(s) for s in support]
        value, inner, _ = descent.jacobian(chosen, leading, coefficients)
        gains = descent.gains(chosen, leading, coefficients)
        self._starts = np.cumsum([0, *(len(g) for g in gains)])
        used = np.concatenate(
            [np.array(s, dtype=int) + o for s, o in zip(chosen, self._starts, strict=False)]
        )
        flat = np.concatenate(gains)
        order = np.argsort(-flat, kind="stable")
        others = order[flat[order] > 0.0][: max(_COLUMNS - len(used), 0)]
        # In the order of their groups.
        self._columns = np.sort(np.concatenate([used, others]))
        columns = np.concatenate(
            [
                x[:, own] * row[:, None]
                for x, own, row in zip(descent.columns, self._own(), inner, strict=True)
            ],
            axis=1,
        )
        norms = np.linalg.norm(columns, axis=0)
        self._norms = np.where(norms > 0.0, norms, 1.0)
        columns /= self._norms
        at = np.searchsorted(self._columns, used)
        residual = (value - descent.target.values) * descent.root_w
        target = columns[:, at] @ (coefficients * self._norms[at]) - residual
        rows = np.concatenate([columns, target[:, None]], axis=1)
        self._gram = rows.T @ rows
        self._base = Pivots(self._gram)
        for k in at:
            self._base.turn(int(k))

    def _own(self, among: np.ndarray | None = None) -> list[np.ndarray]:
        """Columns by group, counted within it."""
        k = self._columns if among is None else self._columns[among]
        ends = zip(self._starts[:-1], self._starts[1:], strict=True)
        return [k[(k >= low) & (k < high)] - low for low, high in ends]

    def proposals(self, rng: np.random.Generator, changes: int, more: int = 0) -> Iterator[Proposal]:
        """Supports of `more` terms more than the fit has, the most promising first.

        Args:
            changes: random changes, each followed by the best exchanges.
        """
        found: dict[frozenset[int], float] = {}
        for _ in range(changes):
            for squares, inside in self._changed(rng, more):
                found[inside] = min(squares, found.get(inside, np.inf))
        for inside, squares in sorted(found.items(), key=lambda e: (e[1], sorted(e[0]))):
            k = np.array(sorted(inside))
            gram = self._gram[np.ix_(k, k)] + _RIDGE * np.eye(len(k))
            coefficients = np.linalg.solve(gram, self._gram[k, -1]) / self._norms[k]
            support = [own.tolist() for own in self._own(k)]
            yield Proposal(support, coefficients, float(np.sqrt(max(squares, 0.0))))

    def _changed(self, rng: np.random.Generator, more: int) -> list[tuple[float, frozenset[int]]]:
        pivots = self._base.copy()
        size = int(pivots.inside.sum())
        out = 1 + int(rng.geometric(_OUT)) % _MOST_OUT
        for _ in range(min(out, size - 3)):
            left = int(pivots.inside.sum())
            order = np.argsort(pivots.losses(), kind="stable")[:left]
            pivots.turn(int(order[min(int(rng.exponential(_RANK_OUT * left)), left - 1)]))
        while int(pivots.inside.sum()) < size + more:
            gains = pivots.gains()
            order = np.argsort(-gains, kind="stable")
            order = order[gains[order] > 0.0]
            if not len(order):
                return []
            pivots.turn(int(order[min(int(rng.exponential(_RANK_IN)), len(order) - 1)]))
        found = pivots.exchange(_EXCHANGES) if int(pivots.inside.sum()) == size + more else []
        return [entry for entry in found if entry[0] > 0.0]
