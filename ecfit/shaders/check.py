"""Exported approximations against NumPy: one tool, or one after the other."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError
from ecfit.export.code import default_name
from ecfit.export.contract import fingerprint
from ecfit.shaders.agreement import Agreement, agreement
from ecfit.shaders.cases import Case, case, enough, few_arguments
from ecfit.shaders.devices import NoDevice
from ecfit.shaders.tools import Tool


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
    enough(count)
    return _reports(_distinct(approximations), tools, count, asked)


def _distinct(approximations: Iterable[Approximation]) -> list[Approximation]:
    """What can be exported, each once."""
    found: dict[str, Approximation] = {}
    for one in approximations:
        few_arguments(one)
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
