"""Which columns of a linear least-squares problem to keep: all exchanges of a term at once, by pivoting.

The sweep operator (Beaton 1964, Goodnight 1979) turns the Gram matrix of all columns and the target into
coefficients, the sum of squares, and what any column in or out would change of it.
"""

import numpy as np

# A column whose square outside the span of the others is less than this part of itself adds nothing.
_DEPENDENT = 1e-9


class Pivots:
    """Columns of a linear least-squares problem, each in or out.

    Args:
        gram: products of the columns and, last, the target, shape (n + 1, n + 1); columns of length 1.
    """

    def __init__(self, gram: np.ndarray) -> None:
        self._a = np.array(gram, dtype=np.float64)
        self.inside: np.ndarray = np.zeros(len(gram) - 1, dtype=bool)

    def copy(self) -> "Pivots":
        out = object.__new__(Pivots)
        out._a, out.inside = self._a.copy(), self.inside.copy()
        return out

    @property
    def squares(self) -> float:
        """The sum of squares that the columns inside leave."""
        return float(self._a[-1, -1])

    @property
    def coefficients(self) -> np.ndarray:
        """Of all columns, shape (n,); 0 for those outside."""
        return np.where(self.inside, self._a[:-1, -1], 0.0)

    def turn(self, k: int) -> None:
        """Put column k in, or take it out."""
        a, sign = self._a, -1.0 if self.inside[k] else 1.0
        row = a[k] / a[k, k]
        pivot = -1.0 / a[k, k]
        column = a[:, k].copy()
        a -= np.multiply.outer(column, row)
        a[k], a[:, k] = sign * row, sign * row
        a[k, k] = pivot
        self.inside[k] = not self.inside[k]

    def gains(self) -> np.ndarray:
        """What each column outside would take off the sum of squares; -1 for the others."""
        a = self._a
        rest = np.diag(a)[:-1]
        good = ~self.inside & (rest > _DEPENDENT)
        with np.errstate(all="ignore"):
            return np.where(good, a[:-1, -1] ** 2 / rest, -1.0)

    def losses(self) -> np.ndarray:
        """What the sum of squares would grow by without each column inside; infinite for the others."""
        a = self._a
        with np.errstate(all="ignore"):
            return np.where(self.inside, -(a[:-1, -1] ** 2) / np.diag(a)[:-1], np.inf)

    def best_exchange(self) -> tuple[float, int, int]:
        """(gain, out, in) of the exchange of one column that lowers the sum of squares most."""
        a, out = self._a, np.flatnonzero(self.inside)
        into = np.flatnonzero(~self.inside)
        if not len(out) or not len(into):
            return 0.0, -1, -1
        diagonal, right = np.diag(a), a[:-1, -1]
        d, y = diagonal[out][:, None], right[out][:, None]
        cross = a[np.ix_(out, into)]
        with np.errstate(all="ignore"):
            rest = diagonal[into] - cross**2 / d
            left = right[into] - cross * y / d
            change = np.where(rest > _DEPENDENT, left**2 / rest, -np.inf) + y**2 / d
        best = np.unravel_index(int(np.argmax(change)), change.shape)
        return float(change[best]), int(out[best[0]]), int(into[best[1]])

    def exchange(self, most: int, least: float = 1e-3) -> list[tuple[float, frozenset[int]]]:
        """Make best exchanges, at most so many and while each lowers the sum of squares by the part `least`.

        Returns the sum of squares and the columns inside at the start and after each.
        """
        found = [(self.squares, frozenset(np.flatnonzero(self.inside).tolist()))]
        for _ in range(most):
            gain, out, into = self.best_exchange()
            if not gain > least * self.squares:
                break
            self.turn(out)
            self.turn(into)
            found.append((self.squares, frozenset(np.flatnonzero(self.inside).tolist())))
        return found
