"""What is known of an approximation's errors, in words: from its certificate, or from its study."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ecfit.approximation import Approximation, find, shipped
from ecfit.approximation.shipped import shipped_folder
from ecfit.files import read_json
from ecfit.tables import Table

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


def source(name: str) -> tuple[Approximation, list[str]]:
    """An approximation and what is known of its errors, by a name of `find` or from a table's file (NPZ).

    Raises `EcfitError` for an unknown name and a file that is missing or holds something else.
    """
    if name.endswith(".npz"):
        label = Path(name).stem
        return Approximation.lookup(Table.load(name), label), [f"{UNKNOWN}: between its nodes"]
    found = find(name)
    return found, evidence_of(read_json(Path(name))) if name.endswith(".json") else evidence_for(found)


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
    drifts = [certificate[k] for k in ("single", "single_hard")]
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
    largest, points = max(d["largest"] for d in drifts), sum(d["points"] for d in drifts)
    out.append(f"float32 rounding adds at most {_short(largest)} (measured at {points} points)")
    if certificate.get("certified") and certificate.get("values"):
        low, high = certificate["values"]["low"], certificate["values"]["high"]
        out.append(f"proved on the closed domain: no division by 0, values in [{low:.4g}, {high:.4g}]")
    return out


def _short(x: float | None) -> str:
    return "inf" if x is None else f"{x:.2g}"
