"""Exported approximations against NumPy: what a tool's program gives, in units in the last place."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError
from ecfit.export import LANGUAGES, code
from ecfit.export.code import default_name, expression, value_function
from ecfit.export.compensation import LEAST as LEAST_ALBEDO
from ecfit.export.compensation import factors
from ecfit.export.contract import fingerprint
from ecfit.export.coordinates import Arguments, arguments
from ecfit.export.slopes import slope
from ecfit.export.ulps import exact, points, ulps
from ecfit.expressions import Node, substitute, value
from ecfit.shaders.devices import NoDevice
from ecfit.shaders.program import ARGUMENTS, Function
from ecfit.shaders.tools import Tool

# The part of the domain that a second number is given for.
COMMON = 95.0
# Half a unit in the last place of 1. Nearer to zero the unit stays that of this number: a difference of 2^-47
# is nothing to an albedo.
FLOOR = 2.0**-24
# Twice the corners of the largest box.
LEAST = 2 * 2**ARGUMENTS
# A target may lose as much again as NumPy's single precision does, as shading languages leave the order of
# operations, roots and quotients some freedom; and an ulp of 1 where NumPy happens to be exact.
AGAIN, ULP = 2.0, 2.0**-23


@dataclass(frozen=True)
class Agreement:
    """How the values of one exported function compare, at points of the closed domain.

    Attributes:
        name: of the function.
        points: how many points.
        worst: largest distance from NumPy's float32 value of the same expression, in ulps.
        place: its coordinates.
        largest: largest absolute difference from NumPy's float32 value.
        exact_common, exact_worst: distances from the exact value (of the same numbers), in ulps: what 95 % of
            uniform points stay below, and the largest.
        error, numpy_error: largest absolute difference from the exact value, of the tool and of NumPy's
            float32.
        not_finite: how many values are NaN or infinite.
        unknown: at how many points NumPy's float32, or the exact value, is NaN or infinite, so that there is
            nothing to compare with.
    """

    name: str
    points: int
    worst: float
    place: Mapping[str, float]
    largest: float
    exact_common: float
    exact_worst: float
    error: float
    numpy_error: float
    not_finite: int
    unknown: int

    @property
    def passes(self) -> bool:
        """Whether all values are finite, NumPy's too, and about as exact as NumPy's float32."""
        finite = not self.not_finite and not self.unknown
        return finite and self.error <= AGAIN * self.numpy_error + ULP

    def describe(self) -> str:
        """One line."""
        at = ", ".join(f"{k} = {v:.6g}" for k, v in self.place.items())
        where = f" at {at}" if self.worst else ""
        bad = f"; {self.not_finite} values are not finite" if self.not_finite else ""
        bad += f"; NumPy's are not at {self.unknown} points" if self.unknown else ""
        return (
            f"{self.name}: at most {self.worst:.3g} ulps from NumPy's float32{where}; "
            f"from the exact value {self.exact_common:.3g} on {COMMON:g} %, "
            f"{self.exact_worst:.3g} at most{bad}"
        )


class Outcome(NamedTuple):
    """What a tool made of exported code.

    Attributes:
        device: where it ran, "" if it was compiled only.
        agreements: one a function; empty if it was compiled only.
    """

    device: str
    agreements: tuple[Agreement, ...]

    @property
    def worst(self) -> Agreement | None:
        """The function that is farthest from NumPy."""
        return max(self.agreements, key=lambda a: a.worst, default=None)


class Report(NamedTuple):
    """One tool's part in `check_all`.

    Attributes:
        tool: which.
        outcome: what it made of the code, or None.
        reason: why there is no outcome: what is missing, or "" if it failed.
        fault: what it refused or how it failed, or "".
        asked: whether the tool was asked for by name.
    """

    tool: Tool
    outcome: Outcome | None = None
    reason: str = ""
    fault: str = ""
    asked: bool = False

    @property
    def passes(self) -> bool:
        """Whether nothing is wrong; a tool that is not there is a fault only if it was asked for."""
        if self.outcome is None:
            return not (self.fault or self.asked)
        return all(a.passes for a in self.outcome.agreements)

    @property
    def done(self) -> str:
        """In a word: run, compiled, failed, or not here."""
        if self.fault:
            return "failed"
        if self.outcome is None:
            return "not here"
        return "run" if self.outcome.agreements else "compiled"

    def describe(self) -> str:
        """A line for the tool, then one for each function at fault, or for the one farthest from NumPy."""
        start = f"{self.tool.name} ({self.tool.language}): {self.done}"
        if self.outcome is None:
            return f"{start}: {self.fault or self.reason}"
        worst = self.outcome.worst
        if worst is None:
            return f"{start} ({self.tool.versions()})"
        shown = [a for a in self.outcome.agreements if not a.passes]
        head = f"{start}: {len(self.outcome.agreements)} functions on {self.outcome.device}"
        verdict = f"{len(shown)} at fault" if shown else "all right"
        lines = [f"{head}: {verdict}", *(f"  {a.describe()}" for a in shown or [worst])]
        return "\n".join(lines)


@dataclass(frozen=True)
class Case:
    """An exported function with the expression that it is to compute.

    Attributes:
        function: the source text.
        expression: of the function's arguments.
        taken: the arguments, in order.
    """

    function: Function
    expression: Node
    taken: Arguments

    def points(self, count: int, seed: int) -> np.ndarray:
        """Points (count, 4) float32 of the closed domain: first corners and edges, then uniform ones.

        Coordinates that the function does not take are 0. Raises `EcfitError` for fewer than `LEAST` points.
        """
        _enough(count)
        edged, uniform = _split(count)
        parts = points(self.taken, edged, seed), points(self.taken, uniform, seed + 1, edges=False)
        out = np.zeros((count, ARGUMENTS), dtype=np.float32)
        for i, name in enumerate(self.taken.names):
            out[:, i] = np.concatenate([part[name] for part in parts])
        return out

    def inputs(self, given: np.ndarray) -> dict[str, np.ndarray]:
        """Coordinates by name, float32, from points (count, 4)."""
        return {name: given[:, i] for i, name in enumerate(self.taken.names)}


def _enough(count: int) -> None:
    if count < LEAST:
        raise EcfitError(f"{count} points are too few for all corners: take {LEAST} or more")


def _split(count: int) -> tuple[int, int]:
    """How many points have some coordinates at or near an end, and how many are uniform."""
    return count - count // 2, count // 2


def case(
    approximation: Approximation, language: str, coordinates: Sequence[str] = (), clamp: bool = False
) -> Case:
    """An approximation exported to a language; see `ecfit.export.code` for the options.

    Raises `EcfitError` for tables, and for functions of more coordinates than a program takes.
    """
    taken = _few_arguments(approximation, coordinates, clamp)
    # Of one approximation in different coordinates each has a name of its own.
    name = "_".join([default_name(approximation), *coordinates, *["clamped"] * clamp])
    source = code(approximation, language, name=name, coordinates=coordinates, clamp=clamp, evidence=())
    function = Function(name, len(taken.names), source)
    return Case(function, expression(approximation, taken), taken)


def _few_arguments(
    approximation: Approximation, coordinates: Sequence[str] = (), clamp: bool = False
) -> Arguments:
    """The arguments, as many as a program takes."""
    taken = arguments(approximation, coordinates, clamp)
    if len(taken.names) > ARGUMENTS:
        raise EcfitError(f"'{approximation.name}' has {len(taken.names)} coordinates, at most {ARGUMENTS}")
    return taken


def family(approximation: Approximation, language: str, derivative: str) -> list[Case]:
    """The value, its factors 1 / E and the slope by an argument, all exported in one file.

    Of a colour's channels, which are alike, one is taken. Raises `EcfitError` as `ecfit.export.code`.
    """
    name, taken = default_name(approximation), arguments(approximation, (), False)
    source = code(approximation, language, factor=True, derivative=derivative, evidence=())
    first = value_function(approximation, name, taken)
    found = [Case(Function(name, len(taken.names), source), first.value, taken)]
    for other in (*factors(approximation, name, taken, LEAST_ALBEDO), slope(first, taken, derivative)):
        more = [n for n in other.arguments if n not in taken.names]
        whole = Arguments(other.arguments, (*taken.domain, *[(0.0, 1.0)] * len(more)), taken.transform)
        expression = substitute(other.value, dict.fromkeys(other.calls, first.value))
        call = _call(other.name, other.arguments, other.colours, LANGUAGES[language].colour)
        found.append(Case(Function(other.name, len(other.arguments), "", call), expression, whole))
    return found


def _call(name: str, arguments: Sequence[str], colours: Collection[str], colour: str) -> str:
    """A call with numbers x0, x1, ... where some arguments are colours: grey ones, and red of the result."""
    numbers = [f"x{i}" for i in range(len(arguments))]
    if not colours or colour == "float":
        return f"{name}({', '.join(numbers)})"
    given = [
        f"{colour}({x}, {x}, {x})" if a in colours else x for x, a in zip(numbers, arguments, strict=True)
    ]
    return f"{name}({', '.join(given)}){'[0]' if colour == 'color' else '.x'}"


def check(approximations: Sequence[Approximation], tool: Tool, count: int = 4096, seed: int = 1) -> Outcome:
    """Export approximations, compile them as one program and compare its values with NumPy's.

    Args:
        approximations: formulas of up to four coordinates.
        tool: what compiles and runs.
        count: points of each domain: corners, edges, close to them, anywhere.
        seed: of the points.

    Raises `EcfitError` where the tool is missing, refuses the code or fails, `NoDevice` where there is none.
    """
    missing = tool.missing()
    if missing:
        raise EcfitError(f"{tool.name}: {missing}")
    return compare([case(a, tool.language) for a in approximations], tool, count, seed)


def compare(cases: Sequence[Case], tool: Tool, count: int, seed: int = 1) -> Outcome:
    """The same for functions that are already written."""
    given = np.stack([c.points(count, seed) for c in cases])
    found = tool.run([c.function for c in cases], given)
    if found.values is None:
        return Outcome("", ())
    agreements = [agreement(c, x, y) for c, x, y in zip(cases, given, found.values, strict=True)]
    return Outcome(found.device, tuple(agreements))


def check_all(
    approximations: Iterable[Approximation], tools: Iterable[Tool], count: int = 4096, asked: bool = False
) -> Iterator[Report]:
    """`check` with one tool after the other; what is missing or fails is said, not raised.

    Args:
        approximations: the same one twice counts once.
        tools: see `TOOLS`.
        count: points of each domain.
        asked: whether the tools were asked for by name: it is then a fault if one is not there.

    Raises `EcfitError` for what is no fault of any tool: too few points, tables and other approximations that
    cannot be exported, and different ones of one name.
    """
    _enough(count)
    return _reports(_distinct(approximations), tools, count, asked)


def _distinct(approximations: Iterable[Approximation]) -> list[Approximation]:
    """What can be exported, each once."""
    found: dict[str, Approximation] = {}
    for one in approximations:
        _few_arguments(one)
        one.expression()
        name = default_name(one)
        if fingerprint(found.setdefault(name, one)) != fingerprint(one):
            raise EcfitError(f"two different approximations are called '{name}': compare one at a time")
    return list(found.values())


def _reports(
    approximations: Sequence[Approximation], tools: Iterable[Tool], count: int, asked: bool
) -> Iterator[Report]:
    written: dict[str, list[Case]] = {}  # exported once a language
    for tool in tools:
        missing = tool.missing()
        if missing:
            yield Report(tool, reason=missing, asked=asked)
            continue
        try:
            if tool.language not in written:
                written[tool.language] = [case(a, tool.language) for a in approximations]
            yield Report(tool, compare(written[tool.language], tool, count))
        except NoDevice as error:
            yield Report(tool, reason=str(error), asked=asked)
        except EcfitError as error:
            yield Report(tool, fault=str(error))


def agreement(case: Case, given: np.ndarray, found: np.ndarray) -> Agreement:
    """Compare values (n,) float32 at points (n, 4) with NumPy's."""
    inputs = case.inputs(given)
    single = np.broadcast_to(value(case.expression, inputs), found.shape)
    double = exact(case.expression, inputs)
    steps, off = ulps(found, single, FLOOR), ulps(found, double, FLOOR)
    worst, uniform = int(np.argmax(steps)), _split(len(found))[0]
    return Agreement(
        name=case.function.name,
        points=len(found),
        worst=float(steps[worst]),
        place={name: float(given[worst, i]) for i, name in enumerate(case.taken.names)},
        largest=_apart(found, single),
        exact_common=float(np.percentile(off[uniform:], COMMON)),
        exact_worst=float(np.max(off)),
        error=_apart(found, double),
        numpy_error=_apart(single, double),
        not_finite=int(np.sum(~np.isfinite(found))),
        unknown=int(np.sum(~(np.isfinite(single) & np.isfinite(double)))),
    )


def _apart(x: np.ndarray, y: np.ndarray) -> float:
    """The largest absolute difference; infinite where one is not finite and the other another number."""
    with np.errstate(invalid="ignore"):
        difference = np.abs(x.astype(np.float64) - y.astype(np.float64))
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    return float(np.max(np.where(same, 0.0, np.where(np.isnan(difference), np.inf, difference))))
