"""What is known of an approximation's errors, in words: from its certificate, or from its study."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ecfit.approximation import Approximation, shipped
from ecfit.approximation.shipped import shipped_folder
from ecfit.files import read_json

UNKNOWN = "against the model: not measured here"


def evidence_of(data: Mapping[str, Any]) -> list[str]:
    """Lines on errors from the data of a file: its certificate, or the errors on its study's table."""
    if data.get("certificate"):
        return _certified(data["certificate"])
    if data.get("fit"):
        errors = data["fit"]["errors"]
        return [
            f"on the nodes of the table it was fitted to: largest {_short(errors['max_error'])}, "
            f"mean {_short(errors['mae'])}, RMS {_short(errors['rmse'])} (double precision; not certified)"
        ]
    return [UNKNOWN]


def evidence_from(name: str) -> list[str] | None:
    """The same from a JSON file of a fit; None for the name of a shipped or published one."""
    return evidence_of(read_json(Path(name))) if name.endswith(".json") else None


def evidence_for(approximation: Approximation) -> list[str]:
    """The same of an approximation alone: what is known if it is a shipped one."""
    if approximation.name in shipped():
        same = shipped(approximation.name).to_dict()
        if json.dumps(same) == json.dumps(approximation.to_dict()):
            return evidence_of(read_json(shipped_folder() / f"{approximation.name}.json"))
    return [UNKNOWN]


def _certified(certificate: Mapping[str, Any]) -> list[str]:
    out = []
    errors = certificate.get("errors")
    drifts = [certificate[k]["largest"] for k in ("single", "single_hard")]
    if errors:
        sampling = certificate["sampling"]
        ranges = ", ".join(f"{k} in [{a:g}, {b:g}]" for k, (a, b) in sampling["ranges"].items())
        out.append(
            f"largest {_short(errors['max_error'])}, mean {_short(errors['mae'])} at {errors['points']} "
            f"random points, {ranges}; |E / value - 1| at most {_short(errors['furnace_max'])}, "
            f"below {_short(errors['furnace_p99'])} at 99 % of them"
        )
    if certificate.get("corner_errors"):
        out.append(f"largest {_short(certificate['corner_errors']['max_error'])} outside that, to the corner")
    out.append(f"float32 rounding adds at most {_short(max(drifts))} (measured at 40000 points)")
    if certificate.get("certified") and certificate.get("values"):
        low, high = certificate["values"]["low"], certificate["values"]["high"]
        out.append(f"proved on the closed domain: no division by 0, values in [{low:.4g}, {high:.4g}]")
    return out or [UNKNOWN]


def _short(x: float | None) -> str:
    return "inf" if x is None else f"{x:.2g}"
