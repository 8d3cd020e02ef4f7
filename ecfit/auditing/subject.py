"""What is audited: a table or a formula as a reading, what it may drift, and faults that need no integral."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.approximation import Approximation, find, published_names, shipped
from ecfit.approximation.shipped import shipped_folder
from ecfit.auditing.drift import at
from ecfit.auditing.reading import Reading
from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.files import read_json
from ecfit.tables import Table
from ecfit.tables.scattered import of_contract

# A quarter of one step of an 8-bit image: what nobody sees of a table whose errors nobody stated.
UNSTATED = 1e-3
# Published formulas are off by 2e-2 to 1e-1 where surfaces are smooth and seen at grazing angles.
UNSTATED_FORMULA = 5e-2
# Our own tables: integrals meet 1e-7, and half a digit is left for other versions of the rules.
_OWN = 1e-6
# A formula's stated largest error is that of another sample of points: half as much again is still it.
_OTHER_SAMPLE = 1.5
# Values this far outside [0, 1] are no error of a fit, but a pole.
_FAR = 0.5
# Nodes an axis where a formula is sampled, by number of variables; and of the grid searched for poles.
_NODES = {1: 64, 2: 16, 3: 8}
_SEARCHED = {1: 2049, 2: 129, 3: 33}
# Nodes keep this part of the range from its ends: formulas are made for r > 0.02 or so.
_MARGIN = 0.02


@dataclass(frozen=True)
class Finding:
    """A fault: its name, and what was found in a sentence."""

    name: str
    sentence: str


@dataclass(frozen=True, eq=False)
class Subject:
    """What an audit starts from.

    Attributes:
        name: for people.
        reading: the claimed reading.
        tolerance: largest drift that is allowed, and `why`.
        findings: faults that are seen without an integral.
    """

    name: str
    reading: Reading
    tolerance: float
    why: str
    findings: tuple[Finding, ...]


def subject_of(what: Any, contract: Contract | None, tolerance: float | None) -> Subject:
    """A table, an approximation, a table file of ours (NPZ), the JSON file of a fit, or a fit's name.

    Raises `EcfitError` for anything else and for a tolerance that is none.
    """
    name, stated = "table", None
    if isinstance(what, str | Path):
        name = str(what)
        if name.endswith(".npz"):
            what = Table.load(name)
        else:
            stated = _stated(name)
            what = find(name)
    if isinstance(what, Table):
        made = _of_table(what, name, contract)
    elif isinstance(what, Approximation):
        made = _of_formula(what, contract, stated)
    else:
        raise EcfitError(f"an audit needs a table, a fit, or a file or name of one, got {what!r}")
    if tolerance is None:
        return made
    if isinstance(tolerance, bool) or not (isinstance(tolerance, int | float) and 0.0 < tolerance < np.inf):
        raise EcfitError(f"tolerance must be a positive number, got {tolerance!r}")
    return replace(made, tolerance=float(tolerance), why="as asked for")


def _of_table(table: Table, name: str, contract: Contract | None) -> Subject:
    reading = Reading(table.axes, table.values, contract or table.contract)
    known = table.errors[np.isfinite(table.errors)]
    if known.size:
        tolerance, why = max(_OWN, 2.0 * float(known.max())), "twice its own largest error estimate"
        if tolerance == _OWN:
            why = "tables of ecfit are integrated to 1e-7"
    else:
        tolerance, why = UNSTATED, "its errors are not stated: a quarter of one 8-bit step"
    return Subject(name, reading, tolerance, why, tuple(_in_values(reading)))


def _in_values(reading: Reading) -> list[Finding]:
    """NaN, and values on both sides of the range of an albedo next to each other."""
    out = []
    bad = np.flatnonzero(~np.isfinite(reading.values))
    if bad.size:
        first = at(reading.place(int(bad[0])))
        out.append(
            Finding(
                "NaN", f"{bad.size} of {reading.values.size} values are NaN or infinite, first at {first}"
            )
        )
    if _bounded(reading.contract):
        finite = np.where(np.isfinite(reading.values), reading.values, 0.5)
        for axis in range(finite.ndim):
            x = np.moveaxis(finite, axis, -1)
            jump = np.minimum(x[..., :-1], x[..., 1:]) < -_FAR
            jump &= np.maximum(x[..., :-1], x[..., 1:]) > 1.0 + _FAR
            if jump.any():
                name = reading.axes[axis].name
                low, high = float(finite.min()), float(finite.max())
                text = f"values jump from {high:.3g} to {low:.3g} along {name}, as a formula does at its pole"
                return [*out, Finding("a pole", text)]
    return out


def _bounded(contract: Contract) -> bool:
    try:
        bsdf, quantity = of_contract(contract)
    except EcfitError:
        return False
    return bool(quantity.bounded(bsdf))


def _of_formula(approximation: Approximation, contract: Contract | None, stated: float | None) -> Subject:
    axes = tuple(
        _sampled(name, low, high, _NODES.get(len(approximation.domain), 5))
        for name, (low, high) in zip(approximation.variables, approximation.domain, strict=True)
    )
    claimed = contract or approximation.contract
    with np.errstate(all="ignore"):
        values = approximation.on_grid([a.nodes for a in axes])
    reading = Reading(axes, values, claimed, formula=True)
    if stated is None:
        tolerance, why = UNSTATED_FORMULA, "it states no error; published formulas are this far off"
    else:
        tolerance, why = (
            _OTHER_SAMPLE * stated,
            f"half as much again as its stated largest error {stated:.2g}",
        )
    return Subject(approximation.name, reading, tolerance, why, tuple(_poles(approximation)))


def _sampled(name: str, low: float, high: float, count: int) -> Axis:
    """Nodes that are dense at both ends and symmetric, so that x and 1 - x are both among them."""
    margin = _MARGIN * (high - low)
    inside = np.sin(0.5 * np.pi * (np.arange(count) + 0.5) / count) ** 2
    nodes = low + margin + (high - low - 2.0 * margin) * inside
    return Axis(name, nodes, nodes, low=low, high=high)


def _poles(approximation: Approximation) -> list[Finding]:
    """A denominator that falls to 0 on the domain, or values far outside the range of an albedo."""
    least = approximation.smallest_denominator()
    if least.value <= 0.0:
        place = at(dict(zip(approximation.variables, least.place, strict=True)))
        text = f"the denominator falls to {least.value:.3g} at {place}: the formula has a pole on its domain"
        return [Finding("a pole", text)]
    count = _SEARCHED.get(len(approximation.domain), 9)
    grid = [np.linspace(low, high, count) for low, high in approximation.domain]
    with np.errstate(all="ignore"):
        values = approximation.on_grid(grid)
    shape = values.shape
    tests: list[tuple[str, Callable[[np.ndarray], np.ndarray], str]] = [
        ("NaN", lambda v: ~np.isfinite(v), "the formula is NaN or infinite")
    ]
    if _bounded(approximation.contract):
        tests.append(
            ("a pole", lambda v: (v < -_FAR) | (v > 1.0 + _FAR), "the values of an albedo reach {value:.3g}")
        )
    for name, test, text in tests:
        bad = np.flatnonzero(test(values).ravel())
        if bad.size:
            index = np.unravel_index(bad[np.argmax(np.abs(values.ravel()[bad]))], shape)
            found = {v: float(g[i]) for v, g, i in zip(approximation.variables, grid, index, strict=True)}
            return [Finding(name, f"{text.format(value=values[index])} at {at(found)}")]
    return []


def _stated(name: str) -> float | None:
    """The largest error that the file of a fit states of itself, or None."""
    if name.endswith(".json"):
        data = read_json(Path(name))
    elif name in published_names() or name not in shipped():
        return None
    else:
        data = read_json(shipped_folder() / f"{name}.json")
    for key in ("certificate", "fit"):
        part = data.get(key) if isinstance(data, dict) else None
        errors = part.get("errors", part) if isinstance(part, dict) else None
        value = errors.get("max_error") if isinstance(errors, dict) else None
        if isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < np.inf:
            return float(value)
    return None
