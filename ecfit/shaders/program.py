"""Many functions in one program: the text that a target compiles, with an entry that calls each."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ecfit.errors import EcfitError

# A point has so many numbers in the drivers' arrays, as a texel has; a function takes the first of them.
ARGUMENTS = 4

_ENTRIES = Path(__file__).with_name("entries")
# How a function is chosen by its number where it is not C's way.
# Mesa's GLSL compiler makes nested branches of a switch, and llvmpipe follows no more than 80 without a word.
_FLAT = "if (f == {}) value = {};"
_CASES = {".wgsl": "case {}: {{ value = {}; }}", ".osl": _FLAT, ".glsl": _FLAT}


@dataclass(frozen=True)
class Function:
    """A function of real numbers as source text.

    Attributes:
        name: how it is called.
        arguments: how many real numbers it takes, at most `ARGUMENTS`.
        source: its definition, with whatever it needs; "" if another function's source has it.
        call: how it is called with x0, x1, ...; by default with these numbers.

    Raises `EcfitError` for more arguments than a program hands on (4), or none.
    """

    name: str
    arguments: int
    source: str
    call: str = ""

    def __post_init__(self) -> None:
        if not 1 <= self.arguments <= ARGUMENTS:
            raise EcfitError(f"'{self.name}' takes {self.arguments} numbers, expected 1 to {ARGUMENTS}")

    @property
    def value(self) -> str:
        """The text of a call."""
        return self.call or f"{self.name}({', '.join(f'x{k}' for k in range(self.arguments))})"


def program(entry: str, functions: Sequence[Function], points: int) -> str:
    """The whole text: functions, and the entry that calls function f at points (f, 0), (f, 1), ...

    Args:
        entry: name of a file in `entries`.
        functions: with names of their own each.
        points: how many of them each function is called at.

    Raises `EcfitError` where two functions have one name.
    """
    names = [f.name for f in functions]
    if len(set(names)) < len(names):
        raise EcfitError("two functions of one program have the same name: give them names of their own")
    case = _CASES.get(Path(entry).suffix, "case {}: value = {}; break;")
    cases = [f"    {case.format(i, f.value)}" for i, f in enumerate(functions)]
    filled = {
        "//@functions": "\n".join(f.source for f in functions),
        "//@cases": "\n".join(cases),
        "@points@": str(points),
        "@functions@": str(len(functions)),
    }
    text = (_ENTRIES / entry).read_text()
    for marker, found in filled.items():
        text = text.replace(marker, found)
    return text
