"""Which terms to keep: floating forward and backward selection with swaps over a set of candidate terms.

Each step looks at the first-order gain of every candidate (or loss of every term) at once, fits the few
best, and keeps the best of those: the result is the best form found for each number of coefficients.
Deterministic: chance enters through the seed only.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ecfit.fitting.descent import REFUSED, Descent, Solved

# Candidates whose fits are tried at each step, and terms tried for removal.
_TRIES = 4
# A change must better the error by this part to be kept: ends cycles of equal forms.
_LEAST_GAIN = 1e-3
# Q's leading term gives way to one whose mean is this many times larger.
_LEAD = 3.0
# Exploration accepts forms that are worse by up to this part, and gives up after so many rounds.
_TOLERATED = 0.1
_PATIENCE = 40


@dataclass(frozen=True, eq=False)
class Found:
    """One form: columns of each group and their coefficients, Q's leading column (with the coefficient 1),
    and the weighted RMS, without and with penalties."""

    support: tuple[tuple[int, ...], ...]
    leading: int
    coefficients: np.ndarray
    rms: float
    objective: float

    @property
    def count(self) -> int:
        return sum(map(len, self.support))


class Search:
    """Selection of terms among the columns of a `Descent`."""

    def __init__(
        self, descent: Descent, *, strength: float = 1.0, least: float = 0.0, tries: int = _TRIES
    ) -> None:
        self.descent, self.tries = descent, tries
        self.settings = {"strength": strength, "least": least}
        self.best: dict[int, Found] = {}
        self.fits = 0
        self._means = descent.columns[-1].mean(axis=0)

    def fit(
        self, support: Iterable[Iterable[int]], leading: int, start: np.ndarray, **settings: float
    ) -> Found | None:
        """The form on a support from a start; nothing where the descent fails."""
        chosen = [list(s) for s in support]
        # From both starts: either may lead to the better of two minima.
        starts = [start]
        linearised = self.descent.linearised(chosen, leading)
        if linearised is not None and np.all(np.isfinite(linearised)):
            starts.append(linearised)
        found = _least([self._descend(chosen, leading, s, settings) for s in starts])
        if found is None:
            return None
        self._remember(found)
        return found

    def _descend(
        self, chosen: list[list[int]], leading: int, start: np.ndarray, settings: dict[str, float]
    ) -> Found | None:
        solved: Solved = self.descent.solve(chosen, leading, start, **{**self.settings, **settings})  # type: ignore[arg-type]
        self.fits += 1
        # Without Q > 0 at the end there is no form; not so for NaN.
        if not np.all(np.isfinite(solved.coefficients)) or not solved.objective < REFUSED:
            return None
        return self._led(
            Found(tuple(map(tuple, chosen)), leading, solved.coefficients, solved.rms, solved.objective)
        )

    def _led(self, found: Found) -> Found:
        """The same form with Q's largest term leading: a small one would make all coefficients large."""
        columns = found.support[-1]
        if not columns:
            return found
        first = found.count - len(columns)
        own = found.coefficients[first:]
        parts = own * self._means[list(columns)]
        heir = int(np.argmax(parts))
        if parts[heir] <= _LEAD * self._means[found.leading]:
            return found
        values = found.coefficients / own[heir]
        values[first + heir] = 1.0 / own[heir]
        swapped = (*columns[:heir], found.leading, *columns[heir + 1 :])
        return Found((*found.support[:-1], swapped), columns[heir], values, found.rms, found.objective)

    def _remember(self, found: Found) -> None:
        old = self.best.get(found.count)
        if old is None or found.objective < old.objective:
            self.best[found.count] = found

    def _add(self, found: Found) -> Found | None:
        """The best form of one more term."""
        gains = self.descent.gains([list(s) for s in found.support], found.leading, found.coefficients)
        flat = [(g, i, k) for i, gain in enumerate(gains) for k, g in enumerate(gain) if g > 0.0]
        flat.sort(key=lambda e: (-e[0], e[1], e[2]))
        return _least([self._with(found, group, column) for _, group, column in flat[: self.tries]])

    def _drop(self, found: Found, position: int) -> Found | None:
        """The form without one coefficient; position -1 is Q's leading term, whose 1 another then takes."""
        support, at = [list(s) for s in found.support], position
        if position < 0:
            return self._drop_leading(found)
        for group, columns in enumerate(support):
            if at < len(columns):
                if len(columns) == 1 and group < len(support) - 1:
                    return None  # a numerator keeps a term
                del columns[at]
                break
            at -= len(columns)
        return self.fit(support, found.leading, np.delete(found.coefficients, position))

    def _drop_leading(self, found: Found) -> Found | None:
        support = [list(s) for s in found.support]
        first = found.count - len(support[-1])
        own = found.coefficients[first:]
        if not len(own) or own.max() <= 0.0:
            return None
        heir = int(np.argmax(own))
        leading = support[-1].pop(heir)
        rest = np.delete(found.coefficients, first + heir) / own[heir]
        return self.fit(support, leading, rest)

    def _order(self, found: Found) -> np.ndarray:
        """Positions of coefficients, the least missed first."""
        return np.argsort(
            self.descent.losses([list(s) for s in found.support], found.leading, found.coefficients),
            kind="stable",
        )

    def _remove(self, found: Found) -> Found | None:
        """The best form of one term less."""
        return _least([self._drop(found, int(p)) for p in self._order(found)[: self.tries]])

    def grow(self, found: Found, most: int) -> None:
        """Floating forward selection up to `most` coefficients."""
        current: Found | None = found
        while current is not None and current.count < most:
            current = self._add(current)
            while current is not None and current.count > 3:
                known = self.best.get(current.count - 1)
                smaller = self._remove(current)
                if smaller is None or known is None or not _better(smaller, known):
                    break
                current = smaller
            if current is not None:
                current = self.best[current.count]

    def merge(self, other: "Search") -> None:
        """Take over what another search of the same columns found better."""
        for found in other.best.values():
            self._remember(found)
        self.fits += other.fits

    def randomised(self, found: Found, rng: np.random.Generator, terms: int = 4) -> Found:
        """The form with a few terms of high gain added, drawn by rank."""
        for _ in range(terms):
            found = self._add_random(found, rng) or found
        return found

    def swap(self, count: int, removals: int | None = None) -> None:
        """Exchange single terms of the best form of `count` coefficients until none betters it."""
        improved = True
        while improved and count in self.best:
            improved = False
            best = self.best[count]
            for position in [*self._order(best)[:removals], -1]:
                smaller = self._drop(best, int(position))
                if smaller is None:
                    continue
                found = self._add(smaller)
                if found is not None and _better(found, best):
                    improved = True
                    break

    def explore(self, count: int, rng: np.random.Generator, rounds: int) -> None:
        """Random exchanges of one to four terms, accepted where they lose little: leads out of local minima.

        Starts from the best form of `count` coefficients and returns to it after `_PATIENCE` rounds without
        a better one.
        """
        if count not in self.best:
            return
        current, idle = self.best[count], 0
        for _ in range(rounds):
            trial = self._exchange(current, 1 + int(rng.geometric(0.5)) % 4, rng)
            before = self.best[count] if trial is None else min(self.best[count], current, key=_objective)
            if trial is not None and trial.objective < current.objective * (1.0 + _TOLERATED * rng.random()):
                current = trial
            idle = 0 if trial is not None and _better(trial, before) else idle + 1
            if idle >= _PATIENCE:
                current, idle = self.best[count], 0

    def _exchange(self, found: Found, out: int, rng: np.random.Generator) -> Found | None:
        """`out` terms dropped, the less missed the likelier, and as many added, by their gains."""
        current: Found | None = found
        for _ in range(min(out, found.count - 3)):
            assert current is not None
            order = self._order(current)
            place = int(rng.exponential(0.3 * len(order)))
            # Beyond the last: Q's leading term.
            position = int(order[place]) if place < len(order) else -1
            current = self._drop(current, position) or current
        while current is not None and current.count < found.count:
            current = self._add_random(current, rng)
        return current

    def _add_random(self, found: Found, rng: np.random.Generator) -> Found | None:
        """One more term: among those of the highest gains, drawn by rank."""
        gains = self.descent.gains([list(s) for s in found.support], found.leading, found.coefficients)
        sizes = [len(g) for g in gains]
        order = np.argsort(-np.concatenate(gains), kind="stable")
        place = int(order[min(int(rng.exponential(2.0)), len(order) - 1)])
        group = 0
        while place >= sizes[group]:
            place, group = place - sizes[group], group + 1
        return self._with(found, group, place)

    def _with(self, found: Found, group: int, column: int) -> Found | None:
        support = [list(s) for s in found.support]
        if column in support[group] or (group == len(support) - 1 and column == found.leading):
            return None
        at = sum(len(s) for s in support[: group + 1])
        support[group].append(column)
        return self.fit(support, found.leading, np.insert(found.coefficients, at, 0.0))


def _objective(found: Found) -> float:
    return found.objective


def _better(new: Found, old: Found) -> bool:
    return new.objective < old.objective * (1.0 - _LEAST_GAIN)


def _least(results: Iterable[Found | None]) -> Found | None:
    good = [r for r in results if r is not None]
    return min(good, key=lambda r: r.objective, default=None)
