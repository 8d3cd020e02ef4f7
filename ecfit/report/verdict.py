"""The verdict of a report: the best approximation for each budget, what a furnace shows, what is proved."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ecfit.approximation import Approximation
from ecfit.certify import prove
from ecfit.errors import EcfitError
from ecfit.files import read_json, write_json
from ecfit.report.entries import Entry, best

# Numbers that a shader may store: about those of the shipped fits. After the last, any number.
BUDGETS = (5, 10, 20, 40)
# The proofs of larger formulas take minutes and fail for want of boxes.
_PROVED_NUMBERS = 64
# What is judged beside fits, in the order of the verdict.
_NOUNS = {"published": "published approximations", "shipped": "the fits shipped with ecfit"}
# Raised where the same formula may be judged otherwise than before.
_PROOFS = "proofs-1"


@dataclass(frozen=True)
class Proved:
    """What proofs say of an approximation.

    Attributes:
        word: "certified", "not certified", or "-" where there is nothing to prove.
        why: one line for people.
    """

    word: str
    why: str


Prover = Callable[[Approximation], Proved]


@dataclass(frozen=True, eq=False)
class Choice:
    """The best approximation within a budget: `budget` numbers, or any number where that is None."""

    budget: int | None
    entry: Entry
    proved: Proved

    @property
    def allowance(self) -> str:
        return "any" if self.budget is None else str(self.budget)


def choices(of: Sequence[Entry], prover: Prover, budgets: Sequence[int] = BUDGETS) -> list[Choice]:
    """The best usable entry for each budget; budgets that better nothing are left out."""
    out: list[Choice] = []
    for budget in (*budgets, None):
        found = best([e for e in of if budget is None or e.count <= budget])
        if found is not None and (not out or found is not out[-1].entry):
            out.append(Choice(budget, found, prover(found.approximation)))
    return out


def sentences(of: Sequence[Entry]) -> list[str]:
    """The verdict in words: the study's best fit and its furnace; the best published and shipped ones."""
    fits = [e for e in of if e.kind == "fit"]
    ours = best(fits)
    out = []
    if not fits:
        out.append("No fits were asked for.")
    elif ours is None:
        worst = fits[0].fit
        out.append(f"No usable fit{': ' + worst.warning() if worst and worst.warning() else ''}.")
    else:
        out.append(_account(ours))
    for kind in _NOUNS:
        others = [e for e in of if e.kind == kind]
        theirs = best([e for e in others if not e.otherwise]) or best(others)
        if theirs is not None:
            out.append(_beside(theirs, [e for e in fits if e.count <= theirs.count]))
    return out


def _account(entry: Entry) -> str:
    e = entry.errors
    said = (
        f"Best fit of the study: {entry.name}, {entry.count} coefficients: MAE {e.mae:.2e}, "
        f"RMSE {e.rmse:.2e}, largest error {e.max_error:.2e}"
    )
    if entry.furnace is None:
        return f"{said}."
    mean, most = entry.furnace
    return (
        f"{said}; a white furnace normalised with it deviates by {percentage(mean)} on average and "
        f"{percentage(most)} at worst."
    )


def percentage(x: float) -> str:
    """A part in per cent, two digits of it: "0.21 %", "730 %"."""
    return f"{100.0 * x:.2g} %" if 100.0 * x < 99.5 else f"{100.0 * x:.0f} %"


def _beside(theirs: Entry, rivals: Sequence[Entry]) -> str:
    """How the best of a kind stands to the study's fits; no rival where it was made for something else."""
    said = f"RMSE {theirs.errors.rmse:.2e}"
    if theirs.otherwise:
        made = ", ".join(theirs.otherwise)
        return f"The {theirs.kind} {theirs.name} was made for {made}: {said} here, and no comparison."
    said = f"Of {_NOUNS[theirs.kind]} {theirs.name}, {theirs.count} numbers, comes nearest: {said}"
    ours = best(rivals)
    if ours is None or ours.errors.rmse <= 0.0:
        return f"{said}."
    ratio = theirs.errors.rmse / ours.errors.rmse
    how = f"{ratio:.3g} times smaller" if ratio >= 1.0 else f"{1 / ratio:.3g} times larger"
    return f"{said}; with no more numbers {ours.name} ({ours.count}) has one {how}."


def prover(folder: Path) -> Prover:
    """A prover that keeps what it finds in `folder/proofs.json`, by a hash of what was proved.

    A proof takes seconds, and depends on nothing but the formula, its domain and its contract.
    """
    path = folder / "proofs.json"
    try:
        known = read_json(path) if path.exists() else {}
    except EcfitError:
        known = {}  # damaged: proved again
    if not isinstance(known, dict):
        known = {}

    def found(approximation: Approximation) -> Proved:
        key = _key(approximation)
        kept = known.get(key)
        if isinstance(kept, dict) and all(isinstance(kept.get(k), str) for k in ("word", "why")):
            return Proved(kept["word"], kept["why"])
        proved = _proved(approximation)
        known[key] = {"name": approximation.name, "word": proved.word, "why": proved.why}
        write_json(path, dict(sorted(known.items())))
        return proved

    return found


def _key(approximation: Approximation) -> str:
    data = [_PROOFS, approximation.to_dict()]
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def _proved(approximation: Approximation) -> Proved:
    if approximation.form == "lookup":
        return Proved("-", "a table: between two entries it interpolates")
    if approximation.count > _PROVED_NUMBERS:
        return Proved("-", f"not tried beyond {_PROVED_NUMBERS} numbers: `ecfit certify` tries")
    try:
        faults = prove(approximation)
    except EcfitError as error:
        return Proved("-", str(error))
    if faults:
        return Proved("not certified", "; ".join(faults))
    return Proved("certified", "no pole and no value outside its bounds on the whole domain: proved")
