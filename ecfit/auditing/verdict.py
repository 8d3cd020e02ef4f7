"""`Audit`: what was compared, what was found, and the likely mistake in words."""

from dataclasses import dataclass

from ecfit.auditing.drift import Drift
from ecfit.auditing.hypotheses import Hypothesis
from ecfit.auditing.reading import Reading
from ecfit.auditing.subject import Finding

# Trials that are shown.
_SHOWN = 6


@dataclass(frozen=True, eq=False)
class Trial:
    """Mistakes that were undone together, and the drift that is left."""

    mistakes: tuple[Hypothesis, ...]
    drift: Drift

    @property
    def name(self) -> str:
        return " and ".join(h.name for h in self.mistakes)

    @property
    def sentence(self) -> str:
        return "; ".join(h.sentence for h in self.mistakes)


@dataclass(frozen=True, eq=False)
class Audit:
    """The result of `ecfit.audit`.

    Attributes:
        name: of the subject.
        claimed: how it is read under its contract.
        drift: differences from the integral in that reading.
        tolerance: largest difference that is allowed, and `why`.
        findings: faults that no other reading mends: NaN, a pole, wrong entries.
        trials: other readings that were tried, the nearest first; none where the claim holds.
        likely: the trial that explains the numbers, or None.
    """

    name: str
    claimed: Reading
    drift: Drift
    tolerance: float
    why: str
    findings: tuple[Finding, ...]
    trials: tuple[Trial, ...]
    likely: Trial | None

    @property
    def within(self) -> bool:
        """Whether no compared entry drifts beyond the tolerance."""
        return self.drift.largest <= self.tolerance

    @property
    def ok(self) -> bool:
        """Whether the subject is what it claims to be, as far as was looked."""
        return self.within and not self.findings

    @property
    def faults(self) -> list[str]:
        """Names of all that is wrong: mistakes of the likely reading, then findings."""
        mistakes = [] if self.likely is None else [h.name for h in self.likely.mistakes]
        return [*mistakes, *(f.name for f in self.findings)]

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
        return "\n".join(self.describe())

    def describe(self) -> list[str]:
        """Lines for people: the verdict, what was claimed, the drift, the likely mistake, what was tried."""
        verdict = "as claimed" if self.ok else ("within tolerance, but" if self.within else "NOT AS CLAIMED")
        contract = self.claimed.contract
        settings = {**contract.options, **{k: f"{v:g}" for k, v in contract.parameters.items()}}
        claim = [contract.quantity, contract.model, *(f"{k} = {v}" for k, v in sorted(settings.items()))]
        out = [f"{self.name}: {verdict}"]
        out += [f"  {f.name}: {f.sentence}" for f in self.findings]
        out += self._explanation()
        out.append(f"  claimed: {', '.join(claim)}, lobe {contract.lobe}, {contract.transport} transport")
        if not self.claimed.formula:
            out += [f"    {axis.describe()}" for axis in self.claimed.axes]
        out.append(f"  drift: {self.drift.describe(self.claimed)}")
        out.append(f"  tolerance: {self.tolerance:.2g} ({self.why})")
        what = "points of a grid" if self.claimed.formula else f"of {self.claimed.values.size} entries"
        left = f"; {self.drift.skipped} left out, not integrated well enough" if self.drift.skipped else ""
        out.append(f"  compared: {self.drift.entries.size} {what}{left}")
        if self.trials:
            shown = self.trials[:_SHOWN]
            title = f"other readings ({len(self.trials)} tried)"
            width = max(len(title) - 2, *(len(t.name) for t in shown))
            out.append(f"  {title:<{width + 2}}   mean drift    largest")
            out += [f"    {t.name:<{width}}   {t.drift.mean:10.2g} {t.drift.largest:10.2g}" for t in shown]
        return out

    def _explanation(self) -> list[str]:
        if self.likely is not None:
            drift = self.likely.drift
            nearly = "" if drift.trimmed_largest <= self.tolerance else " (nearest; it does not explain all)"
            return [
                f"  likely: {self.likely.name}: mean drift falls from {self.drift.mean:.2g} to "
                f"{drift.mean:.2g}{nearly}",
                f"    {self.likely.sentence}",
            ]
        if self.trials:
            return ["  likely: none of the mistakes that were tried: no other reading is much nearer"]
        if not self.within and not self.findings:
            return ["  likely: no mistake of convention: only few points are beyond the tolerance"]
        return []
