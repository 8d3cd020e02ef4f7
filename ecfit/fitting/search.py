"""Which terms to keep: growth and exchanges of terms over a set of candidates, proposed in the tangent.

What is kept is the best form found for each number of coefficients. Deterministic: chance enters through the
generator only.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ecfit.fitting.descent import REFUSED, Descent, Solved
from ecfit.fitting.tangent import Proposal, Tangent

Support = list[list[int]]

# Steps of a trial's descent: a good start settles in fewer. A new best descends again, at most so often.
_STEPS, _POLISHES = 12, 4
# Random changes in the tangent for a step of growth and for one of exploration.
_CHANGES_GROWTH, _CHANGES = 20, 30
# Fits for a step of growth; of proposals whose tangent has no positive Q, so many are rescued.
_FITS, _RESCUED = 3, 10
# While a form has fewer terms than this the tangent says little, and plain gains are tried too.
_SMALL, _TRIES = 8, 4
# Random terms are drawn by rank of their gain, exponentially with this mean.
_RANK = 2.0
# A change must better the error by this part to count.
_LEAST_GAIN = 1e-3
# Q's leading term gives way to one whose mean is this many times larger; in exploration, any whose mean is
# this part of its own may lead, so that the leading one can go.
_LEAD, _MAY_LEAD = 3.0, 0.05
# Exploration accepts forms that are worse by up to this part, goes back to the best after so many fits
# without a better one, and looks at so many proposals of one tangent.
_TOLERATED, _PATIENCE, _STALE = 0.1, 40, 8
# Q, of mean 1, counts as positive from here: above what a term of higher order is at the guards' corner.
_LEAST_Q = 1e-5


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

    @property
    def chosen(self) -> Support:
        return [list(s) for s in self.support]

    @property
    def denominator(self) -> np.ndarray:
        """Coefficients of Q without its leading 1."""
        return self.coefficients[self.count - len(self.support[-1]) :]

    def led_by(self, heir: int) -> "Found":
        """The same form with the coefficient 1 at Q's term of this position."""
        first = self.count - len(self.support[-1])
        columns, size = self.support[-1], self.coefficients[first + heir]
        values = self.coefficients / size
        values[first + heir] = 1.0 / size
        swapped = (*columns[:heir], self.leading, *columns[heir + 1 :])
        return replace(
            self, support=(*self.support[:-1], swapped), leading=columns[heir], coefficients=values
        )


class Search:
    """Selection of terms among the columns of a `Descent`.

    Args:
        descent: candidates, target and guards.
        strength: weight of what exceeds the head's limits.
        operations: cost of a support and leading column in multiply-adds, or None.
        price: relative growth of the error that one multiply-add less is worth.
        rounding: what a form may lose in single precision (`Descent.rounding`), or None; one that loses
            four times as much counts as twice as far off.
    """

    def __init__(
        self,
        descent: Descent,
        *,
        strength: float = 1.0,
        operations: Callable[[Support, int], float] | None = None,
        price: float = 0.0,
        rounding: float | None = None,
    ) -> None:
        self.descent, self._rounding = descent, rounding
        self.strength: float = strength
        self.best: dict[int, Found] = {}
        self.fits: int = 0
        self._operations, self._price = operations, price
        self._means = descent.columns[-1].mean(axis=0)
        self._tried: set[tuple] = set()

    def fit(self, support: Support, leading: int, start: np.ndarray) -> Found | None:
        """The form on a support from a start, kept where it is the best of its size.

        Nothing where the descent fails, or Q is not positive at a guard.
        """
        found = self._descend(support, leading, start)
        if found is None or not self._is_best(found):
            return found
        for _ in range(_POLISHES):
            further = self._descend(found.chosen, found.leading, found.coefficients)
            if further is None or not further.objective < found.objective:
                break
            settled, found = further.objective > found.objective * (1.0 - _LEAST_GAIN), further
            if settled:
                break
        self.best[found.count] = found
        return found

    def _is_best(self, found: Found) -> bool:
        old = self.best.get(found.count)
        return old is None or self._dearness(found) < self._dearness(old)

    def _dearness(self, found: Found) -> float:
        """The error, and what it costs to evaluate the form."""
        if self._operations is None or not self._price:
            return found.objective
        return found.objective * (1.0 + self._price * self._operations(found.chosen, found.leading))

    def _descend(self, support: Support, leading: int, start: np.ndarray) -> Found | None:
        solved: Solved = self.descent.solve(
            support, leading, start, rtol=1e-3, max_steps=_STEPS, strength=self.strength
        )
        self.fits += 1
        # Without Q > 0 at the end there is no form; not so for NaN.
        if not np.all(np.isfinite(solved.coefficients)) or not solved.objective < REFUSED:
            return None
        if self.descent.least_q(support, leading, solved.coefficients) <= _LEAST_Q:
            return None
        objective = solved.objective
        if self._rounding is not None:
            # Not a refusal: a search may begin with forms that lose too much, and has to see the way out.
            lost = self.descent.rounding(support, leading, solved.coefficients)
            objective *= max(1.0, lost / self._rounding) ** 0.5
        found = Found(tuple(map(tuple, support)), leading, solved.coefficients, solved.rms, objective)
        # Q's largest term leads: a small one would make all coefficients large.
        parts = found.denominator * self._means[list(found.support[-1])]
        heir = int(np.argmax(parts)) if len(parts) else -1
        worth = heir >= 0 and parts[heir] > _LEAD * self._means[found.leading]
        return found.led_by(heir) if worth else found

    def grow(self, found: Found, most: int, rng: np.random.Generator) -> None:
        """Add terms, one at a time and with exchanges, up to `most` coefficients."""
        while found.count < most:
            tried = list(self._fitted(found, self._tangent(found).proposals(rng, _CHANGES_GROWTH, 1), _FITS))
            if found.count < _SMALL or not tried:
                tried += self._added(found)
            if not tried:
                return
            found = self.best[found.count + 1]

    def _tangent(self, found: Found) -> Tangent:
        return Tangent(self.descent, found.support, found.leading, found.coefficients)

    def _added(self, found: Found) -> list[Found]:
        """Forms of one term more, by first-order gain alone."""
        gains = self.descent.gains(found.chosen, found.leading, found.coefficients)
        flat = [(g, i, k) for i, gain in enumerate(gains) for k, g in enumerate(gain) if g > 0.0]
        flat.sort(key=lambda e: (-e[0], e[1], e[2]))
        made = (self._with(found, group, column) for _, group, column in flat[:_TRIES])
        return [f for f in made if f is not None]

    def with_random_term(self, found: Found, rng: np.random.Generator) -> Found:
        """The form with one more term, drawn by rank of its gain; the form itself where it fails."""
        gains = self.descent.gains(found.chosen, found.leading, found.coefficients)
        ends = np.cumsum([len(g) for g in gains])
        order = np.argsort(-np.concatenate(gains), kind="stable")
        place = int(order[min(int(rng.exponential(_RANK)), len(order) - 1)])
        group = int(np.searchsorted(ends, place, side="right"))
        return self._with(found, group, place - int(ends[group]) + len(gains[group])) or found

    def _with(self, found: Found, group: int, column: int) -> Found | None:
        """The better of two fits with one more term: from the coefficients at hand, and linearised."""
        support, at = found.chosen, sum(map(len, found.support[: group + 1]))
        if column in support[group] or (group == len(support) - 1 and column == found.leading):
            return None
        support[group].append(column)
        starts = [np.insert(found.coefficients, at, 0.0)]
        linearised = self.descent.linearised(support, found.leading)
        if linearised is not None and np.all(np.isfinite(linearised)):
            starts.append(linearised)
        made = (self.fit(support, found.leading, start) for start in starts)
        return min((f for f in made if f is not None), key=_objective, default=None)

    def _fitted(
        self, found: Found, proposals: Iterable[Proposal], most: int, rescued: int = _RESCUED
    ) -> Iterator[Found]:
        """Fits of the most promising proposals that were not tried before."""
        for proposal in proposals:
            if most <= 0:
                return
            if not all(proposal.support[:-1]):
                continue  # a numerator keeps a term
            key = (
                *(tuple(s) for s in proposal.support[:-1]),
                *sorted([*proposal.support[-1], found.leading]),
            )
            if key in self._tried:
                continue
            self._tried.add(key)
            start: np.ndarray | None = proposal.coefficients
            if self._least_q(proposal.support, found.leading, start) <= _LEAST_Q:
                if rescued <= 0:
                    continue
                rescued -= 1
                start = self._rescue(found, proposal.support)
                if start is None:
                    continue
            most -= 1
            made = self.fit(proposal.support, found.leading, start)
            if made is not None:
                yield made

    def _least_q(self, support: Support, leading: int, c: np.ndarray) -> float:
        """The least Q on the rows: guards only pull, so a start may be below 0 there."""
        columns = self.descent.columns[-1]
        return float((columns[:, leading] + columns[:, support[-1]] @ c[len(c) - len(support[-1]) :]).min())

    def _rescue(self, found: Found, support: Support) -> np.ndarray | None:
        """A start with Q > 0: the coefficients of the terms that stay, or a linearised start."""
        old = {
            (g, j): v
            for (g, j), v in zip(
                ((g, j) for g, s in enumerate(found.support) for j in s), found.coefficients, strict=True
            )
        }
        start = np.array([old.get((g, j), 0.0) for g, s in enumerate(support) for j in s])
        if self._least_q(support, found.leading, start) > _LEAST_Q:
            return start
        linearised = self.descent.linearised(support, found.leading)
        return linearised if linearised is not None and np.all(np.isfinite(linearised)) else None

    def explore(self, count: int, rng: np.random.Generator, rounds: int) -> None:
        """Exchange terms of the best form of `count` coefficients, with `rounds` fits.

        Forms that lose little are accepted, which leads out of local minima; the search returns to the best
        form after a while without a better one. First the best forms of one term less and more are tried
        with a term more and less.
        """
        for start, more in ((count - 1, 1), (count + 1, -1)):
            if start in self.best:
                found = self.best[start]
                proposals = self._tangent(found).proposals(rng, _CHANGES, more)
                for _ in self._fitted(found, proposals, _FITS):
                    pass
        if count not in self.best:
            return
        current, idle, looked = self.best[count], 0, _STALE
        trials: Iterator[Found] = iter(())
        for _ in range(rounds):
            if looked >= _STALE:
                led = self._led(current, rng)
                trials, looked = self._fitted(led, self._tangent(led).proposals(rng, _CHANGES), _STALE, 0), 0
            before = self.best[count].objective
            trial = next(trials, None)
            looked = looked + 1 if trial is not None else _STALE
            idle += 1
            if trial is not None:
                if self.best[count].objective < before:
                    trial = self.best[count]
                if trial.objective < current.objective * (1.0 + _TOLERATED * rng.random()):
                    current, looked = trial, _STALE
                if trial.objective < before * (1.0 - _LEAST_GAIN):
                    idle = 0
            if idle >= _PATIENCE:
                current, idle, looked = self.best[count], 0, _STALE

    def _led(self, found: Found, rng: np.random.Generator) -> Found:
        """Half the time, the form led by another of Q's larger terms."""
        parts = found.denominator * self._means[list(found.support[-1])]
        heirs = np.flatnonzero(parts > _MAY_LEAD * self._means[found.leading])
        return found.led_by(int(rng.choice(heirs))) if len(heirs) and rng.random() < 0.5 else found


def _objective(found: Found) -> float:
    return found.objective
