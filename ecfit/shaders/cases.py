"""Exported functions with the expressions that they are to compute, and points at which they are asked."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError
from ecfit.export import LANGUAGES, code
from ecfit.export.code import default_name, expression, value_function
from ecfit.export.compensation import LEAST as LEAST_ALBEDO
from ecfit.export.compensation import factors
from ecfit.export.coordinates import Arguments, arguments
from ecfit.export.slopes import slope
from ecfit.export.ulps import points
from ecfit.expressions import Node, substitute
from ecfit.shaders.program import ARGUMENTS, Function

# Twice the corners of the largest box.
LEAST = 2 * 2**ARGUMENTS
# 256 MB of inputs.
MOST = 2**24


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

        Coordinates that the function does not take are 0. Raises `EcfitError` as `enough`.
        """
        enough(count)
        edged, uniform = split(count)
        parts = points(self.taken, edged, seed), points(self.taken, uniform, seed + 1, edges=False)
        out = np.zeros((count, ARGUMENTS), dtype=np.float32)
        for i, name in enumerate(self.taken.names):
            out[:, i] = np.concatenate([part[name] for part in parts])
        return out

    def inputs(self, given: np.ndarray) -> dict[str, np.ndarray]:
        """Coordinates by name, float32, from points (count, 4)."""
        return {name: given[:, i] for i, name in enumerate(self.taken.names)}


def enough(count: int) -> None:
    """Raises `EcfitError` for fewer than `LEAST` points or more than `MOST`."""
    if count < LEAST:
        raise EcfitError(f"{count} points are too few for all corners: take {LEAST} or more")
    if count > MOST:
        raise EcfitError(f"{count} points are too many: take {MOST} or fewer")


def split(count: int) -> tuple[int, int]:
    """How many points have some coordinates at or near an end, and how many are uniform."""
    return count - count // 2, count // 2


def case(
    approximation: Approximation, language: str, coordinates: Sequence[str] = (), clamp: bool = False
) -> Case:
    """An approximation exported to a language; see `ecfit.export.code` for the options.

    Raises `EcfitError` for tables, and for functions of more coordinates than a program takes.
    """
    taken = few_arguments(approximation, coordinates, clamp)
    # Of one approximation in different coordinates each has a name of its own.
    name = "_".join([default_name(approximation), *coordinates, *["clamped"] * clamp])
    source = code(approximation, language, name=name, coordinates=coordinates, clamp=clamp, evidence=())
    function = Function(name, len(taken.names), source)
    return Case(function, expression(approximation, taken), taken)


def few_arguments(
    approximation: Approximation, coordinates: Sequence[str] = (), clamp: bool = False
) -> Arguments:
    """The arguments of an approximation, as many as a program takes. Raises `EcfitError` for more."""
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
