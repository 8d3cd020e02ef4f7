"""Many functions become one program, each called by its own number."""

import pytest

from ecfit.errors import EcfitError
from ecfit.shaders.program import ARGUMENTS, Function, program
from ecfit.shaders.tools import TOOLS


@pytest.mark.parametrize("entry", sorted({t.entry for t in TOOLS.values()}))
def test_every_entry_calls_every_function_with_its_own_arguments(entry):
    found = program(entry, [Function("first", 1, "FIRST"), Function("second", 4, "SECOND")], 7)
    assert found.count("FIRST") == found.count("SECOND") == 1
    assert "first(x0)" in found
    assert "second(x0, x1, x2, x3)" in found
    left = found.replace("@numbers@", "").replace("@given@", "")  # of OSL: the driver fills them in
    assert "@" not in "".join(line for line in left.splitlines() if not line.startswith(("@", "fn main(@")))


def test_two_functions_of_one_name_are_refused():
    twice = [Function("f", 1, "")] * 2
    with pytest.raises(EcfitError, match="same name"):
        program("library.c", twice, 1)


@pytest.mark.parametrize("count", [0, ARGUMENTS + 1])
def test_too_many_arguments_are_refused(count):
    with pytest.raises(EcfitError, match=f"takes {count} numbers"):
        Function("f", count, "")
