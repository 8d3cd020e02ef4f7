"""`audit`: compare with the integral; where they differ, undo one mistake after another and compare again."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from ecfit.approximation import Approximation
from ecfit.auditing.drift import Drift, at, drift_of
from ecfit.auditing.hypotheses import SLOTS, Hypothesis, hypotheses
from ecfit.auditing.reading import Reading
from ecfit.auditing.sample import choose
from ecfit.auditing.subject import Finding, subject_of
from ecfit.auditing.verdict import Audit, Trial
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.tables import Table

# A reading that leaves more than this part of the drift explains nothing.
_BETTER = 1.0 / 3.0
# Entries that are wrong by themselves differ by this many times more than the rest do.
_STANDS_OUT = 10.0


def audit(
    subject: Table | Approximation | str | Path,
    *,
    contract: Contract | None = None,
    name: str | None = None,
    samples: int = 256,
    tolerance: float | None = None,
    seed: int = 1,
    told: Callable[[str], None] | None = None,
) -> Audit:
    """Is a table or a formula what its contract says, and if not, what went wrong?

    Args:
        subject: a table, an approximation, a table file of ours (NPZ), the JSON file of a fit, or the name of
            a shipped or published fit.
        contract: what it is claimed to be, in the place of its own contract.
        name: what the subject is called in the report, where it has no name of its own.
        samples: entries that are integrated again; all of a small table.
        tolerance: largest difference from the integral that is allowed; by default what the subject states of
            its errors, else 1e-3 for a table and 5e-2 for a formula.
        seed: of the choice of entries.
        told: called with what is tried next, in words.

    Returns an `Audit`: `.ok`, `.likely`, `.describe()`. Raises `EcfitError` for a subject that cannot be
    read, for a contract without a registered model, and for coordinates outside the model's domain.
    """
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 8:
        raise EcfitError(f"samples must be 8 or more, got {samples!r}")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise EcfitError(f"seed must be 0 or more, got {seed!r}")
    found = subject_of(subject, contract, tolerance)
    claimed = found.reading
    entries = choose(claimed, samples, seed)
    if entries.size < 2:
        raise EcfitError(f"'{found.name}' has no finite entries to compare with the integral")
    first = drift_of(claimed, entries, found.tolerance)
    if first.entries.size < 2:
        raise EcfitError(
            f"'{found.name}': no integral is known to {found.tolerance:.2g}: give a larger tolerance"
        )
    search = _Search(claimed, entries, found.tolerance, told)
    trials: list[Trial] = []
    if first.trimmed_largest > found.tolerance:
        trials = search.run()
    elif first.largest > found.tolerance:
        trials = search.run_at_ends()
    likely = _likely(first, trials, found.tolerance)
    drift = first if likely is None else likely.drift
    return Audit(
        name=name or found.name,
        claimed=claimed,
        drift=first,
        tolerance=found.tolerance,
        why=found.why,
        findings=(*found.findings, *_entries(claimed, drift, found.tolerance)),
        trials=tuple(sorted(trials, key=lambda t: t.drift.trimmed_mean)),
        likely=likely,
    )


class _Search:
    """Mistakes, one and then two at a time, until one explains the numbers."""

    def __init__(
        self, claimed: Reading, entries: np.ndarray, tolerance: float, told: Callable[[str], None] | None
    ) -> None:
        self.claimed, self.entries, self.tolerance, self.told = claimed, entries, tolerance, told
        self.trials: list[Trial] = []

    def run(self) -> list[Trial]:
        """All trials made. The simplest explanation ends the search: cheap ones, then dear, then pairs."""
        known = hypotheses(self.claimed)
        cheap = [h for h in known if h.same_integrals]
        dear = [h for h in known if not h.same_integrals]
        two_cheap = [(a, b) for i, a in enumerate(cheap) for b in cheap[i + 1 :] if a.slot != b.slot]
        stages: list[tuple[str, Iterable[tuple[Hypothesis, ...]]]] = [
            ("order, nodes, coordinates and values", ((h,) for h in cheap)),
            *((h.name, [(h,)]) for h in dear),
            ("two of order, nodes, coordinates and values", two_cheap),
            *((f"{a.name}, and another", [(a, b) for b in cheap]) for a in dear),
        ]
        for words, stage in stages:
            if self.told is not None:
                self.told(words)
            for chosen in stage:
                self._try(chosen)
            if any(t.drift.trimmed_largest <= self.tolerance for t in self.trials):
                break
        return self.trials

    def run_at_ends(self) -> list[Trial]:
        """Trials for a few entries that are off: generators keep cosines and roughness away from 0.

        Only those that explain all of them; else the entries are wrong by themselves.
        """
        for hypothesis in hypotheses(self.claimed):
            if hypothesis.slot == "lowest":
                self._try((hypothesis,))
        return [t for t in self.trials if t.drift.largest <= self.tolerance]

    def _try(self, chosen: tuple[Hypothesis, ...]) -> None:
        ordered = tuple(sorted(chosen, key=lambda h: SLOTS.index(h.slot)))
        reading = self.claimed
        try:
            for hypothesis in ordered:
                reading = hypothesis.change(reading)
            drift = drift_of(reading, self.entries, self.tolerance)
        except EcfitError:  # not a reading: coordinates outside the model's domain, a missing parameter
            return
        if drift.entries.size >= 2:
            self.trials.append(Trial(ordered, drift))


def _likely(claimed: Drift, trials: list[Trial], tolerance: float) -> Trial | None:
    """The simplest trial that explains the numbers, or the nearest where it is much nearer than the claim."""
    explaining = [t for t in trials if t.drift.trimmed_largest <= tolerance]
    if explaining:
        return min(explaining, key=lambda t: (len(t.mistakes), t.drift.trimmed_mean))
    best = {n: min((t for t in trials if len(t.mistakes) == n), key=_score, default=None) for n in (1, 2)}
    chosen, level = None, claimed.trimmed_mean
    for trial in best.values():  # a second mistake must be worth as much as the first
        if trial is not None and _score(trial) <= _BETTER * level:
            chosen, level = trial, _score(trial)
    return chosen


def _score(trial: Trial) -> float:
    return trial.drift.trimmed_mean


def _entries(claimed: Reading, drift: Drift, tolerance: float) -> list[Finding]:
    """Entries that are wrong by themselves, where the others are right."""
    beyond = drift.beyond(tolerance)
    if beyond.size == 0 or drift.trimmed_largest > tolerance or claimed.formula:
        return []
    worst = beyond[: max(1, sum(drift.size[beyond] >= _STANDS_OUT * drift.trimmed_largest))]
    places = [
        f"{at(claimed.place(int(drift.entries[i])))} ({drift.values[i]:.6g}, not {drift.truth[i]:.6g})"
        for i in worst[:3]
    ]
    more = f", and {beyond.size - len(places)} more" if beyond.size > len(places) else ""
    if beyond.size == 1:
        return [Finding("one wrong entry", f"the value at {places[0]} alone is off")]
    return [Finding(f"{beyond.size} wrong entries", f"values at {'; '.join(places)}{more} are off")]
