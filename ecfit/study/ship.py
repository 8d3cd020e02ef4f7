"""From a finished study to shipped fits: certified, with provenance, one file a name."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ecfit._versions import versions
from ecfit.approximation import Approximation
from ecfit.certify import Certificate, certify
from ecfit.errors import EcfitError
from ecfit.files import read_json, write_json
from ecfit.fitting import Fit
from ecfit.study.plan import Plan


@dataclass(frozen=True)
class Shipment:
    """One named fit and what became of it: "shipped", "unchanged", or why it was refused."""

    name: str
    outcome: str
    certificate: Certificate

    @property
    def shipped(self) -> bool:
        return self.outcome in ("shipped", "unchanged")


def ship(
    plan: Plan,
    fits: dict[str, list[Fit]],
    folder: Path,
    *,
    samples: int = 20_000,
    told: Callable[[Shipment], None] | None = None,
) -> list[Shipment]:
    """Certify every fit that the study names, and write the granted ones to `folder`.

    A name that is there with other coefficients is refused: it never changes once released.
    """
    out = []
    for planned, fit in _named(plan, fits):
        certificate = certify(fit.approximation, samples=samples)
        path = folder / f"{planned}.json"
        data = {
            **fit.approximation.to_dict(),
            "certificate": certificate.to_dict(),
            "provenance": {**versions(), "study": plan.config.name, "table": fit.table_key},
        }
        outcome = "shipped"
        if not certificate.certified:
            outcome = "refused: " + "; ".join(certificate.refusals)
        elif path.exists():
            old = Approximation.from_dict(read_json(path), f"'{path}'")
            # Through JSON on both sides: it knows lists only.
            same = json.dumps(old.to_dict()) == json.dumps(fit.approximation.to_dict())
            kept = f"refused: '{path}' holds other coefficients: choose a new name"
            outcome = "unchanged" if same else kept
        if outcome == "shipped":
            write_json(path, data)
        out.append(Shipment(planned, outcome, certificate))
        if told is not None:
            told(out[-1])
    if not out:
        raise EcfitError("the study names no fit: give fits to be shipped a name = ... in the config")
    return out


def _named(plan: Plan, fits: dict[str, list[Fit]]) -> list[tuple[str, Fit]]:
    left = {table: list(found) for table, found in fits.items()}
    named = []
    for planned in plan.fits:
        fit = left[planned.table].pop(0)
        if planned.name is not None:
            named.append((planned.name, fit))
    return named
