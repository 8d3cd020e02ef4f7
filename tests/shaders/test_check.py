"""The comparison itself: it finds a function that is wrong, and says where."""

import numpy as np
import pytest

from ecfit.approximation import shipped
from ecfit.errors import EcfitError
from ecfit.export.coordinates import Arguments
from ecfit.expressions import parse
from ecfit.shaders.agreement import agreement
from ecfit.shaders.cases import Case, case
from ecfit.shaders.check import check, compare
from ecfit.shaders.compilers import CC
from ecfit.shaders.devices import Device, NoDevice
from ecfit.shaders.program import ARGUMENTS, Function
from ecfit.shaders.tools import TOOLS, Tool

needs_cc = pytest.mark.skipif(CC.missing() is not None, reason=str(CC.missing()))


def written(name: str, text: str, source: str, *domain: tuple[float, float]) -> Case:
    """A formula of x, y, ... and the C text of what is said to compute it."""
    names = tuple("xyz"[: len(domain)])
    taken = Arguments(names, domain, lambda node: node)
    parameters = ", ".join(f"float {n}" for n in names)
    full = f"static inline float {name}({parameters}) {{ return {source}; }}"
    return Case(Function(name, len(names), full), parse(text, names), taken)


def test_points_are_in_the_closed_domain_with_all_corners():
    found = case(shipped("dielectric-leaving-20"), "c").points(1000, 1)
    domain = np.array(case(shipped("dielectric-leaving-20"), "c").taken.domain)
    assert found.dtype == np.float32
    assert found.shape == (1000, ARGUMENTS)
    assert np.all(found[:, 3] == 0.0)
    assert np.all((found[:, :3] >= domain[:, 0]) & (found[:, :3] <= domain[:, 1]))
    at_ends = np.isclose(found[:, :3], domain[:, 0]) | np.isclose(found[:, :3], domain[:, 1])
    assert len(np.unique(np.round(found[at_ends.all(axis=1)], 5), axis=0)) >= 8
    # The second half is uniform: no coordinate of it is at an end.
    assert not at_ends[500:].any(axis=1).mean() > 0.01


@needs_cc
def test_right_functions_agree_to_the_last_bit_and_wrong_ones_are_found():
    """Each in one program: a right one, one off by a part in a million, one that is NaN at a corner, and one
    that is wrong on a tiny part only."""
    unit = (0.0, 1.0)
    cases = [
        written("right", "1 - x * y / (2 + x)", "1.0f - x * y / (2.0f + x)", unit, unit),
        written("scaled", "1 - x * y / (2 + x)", "1.000001f - x * y / (2.0f + x)", unit, unit),
        written("corner", "x / max(x, 0.000001)", "x / x", unit),
        written("edge", "x + y", "(x == 1.0f ? 1.5f : x) + y", unit, unit),
    ]
    found = {a.name: a for a in compare(cases, TOOLS["cc"], 512).agreements}
    assert found["right"].worst == 0.0
    assert found["right"].error == found["right"].numpy_error < 1e-7
    assert found["right"].exact_common <= 2.0
    assert 8.0 <= found["scaled"].worst <= 64.0
    assert found["scaled"].largest == pytest.approx(1e-6, rel=0.2)
    assert found["corner"].not_finite >= 1
    assert found["corner"].worst == np.inf
    assert "values are not finite" in found["corner"].describe()
    assert found["edge"].place["x"] == 1.0
    assert found["edge"].error == pytest.approx(0.5)


def test_nan_where_numpy_has_nan_is_no_difference_but_counted():
    one = written("f", "x / x", "x / x", (0.0, 1.0))
    given = one.points(64, 1)
    with np.errstate(invalid="ignore"):
        values = given[:, 0] / given[:, 0]
    found = agreement(one, given, values)
    assert found.worst == 0.0
    assert found.not_finite == int(np.sum(given[:, 0] == 0.0)) > 0


def test_what_numpy_has_no_number_for_is_no_pass():
    """Any finite value is as near to NaN as any other."""
    one = written("f", "x / x", "1.0f", (0.0, 1.0))
    given = one.points(64, 1)
    found = agreement(one, given, np.ones(64, dtype=np.float32))
    assert found.not_finite == 0
    assert found.unknown == int(np.sum(given[:, 0] == 0.0)) > 0
    assert not found.passes
    assert f"NumPy's are not at {found.unknown} points" in found.describe()


def test_differences_near_zero_count_in_units_of_the_floor():
    one = written("f", "x", "x", (0.0, 1.0))
    given = np.zeros((2, ARGUMENTS), dtype=np.float32)
    given[1, 0] = 1.0
    near = agreement(one, given, np.array([1e-30, 1.0], dtype=np.float32))
    assert near.worst < 1e-12
    far = agreement(one, given, np.array([2.0**-46, 1.0], dtype=np.float32))
    assert far.worst == 2.0


@needs_cc
def test_a_few_functions_may_be_one_approximation_in_different_coordinates():
    fit = shipped("dielectric-entering-20")
    views = [(), ("r",), ("r", "ior"), ("ior",)]
    cases = [case(fit, "c", v) for v in views] + [case(fit, "c", ("r",), clamp=True)]
    found = compare(cases, TOOLS["cc"], 256)
    assert len({a.name for a in found.agreements}) == 5
    assert [a.worst for a in found.agreements] == [0.0] * 5


def test_a_missing_tool_is_an_error_with_the_remedy(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(EcfitError, match="cc: no cc: a C compiler"):
        check([shipped("conductor-7")], TOOLS["cc"], 64)


def test_a_driver_that_finds_no_device_is_told_from_one_that_fails(tmp_path, monkeypatch):
    """A driver that dies before it has named its device had none; what dies later is a fault."""
    from ecfit.shaders import devices

    monkeypatch.setattr(devices, "_DRIVERS", tmp_path)
    (tmp_path / "early.py").write_text("raise SystemExit('no screen')")
    late = (
        "import sys, pathlib; pathlib.Path(sys.argv[1], 'device.txt').write_text('x'); sys.exit('bad code')"
    )
    (tmp_path / "late.py").write_text(late)
    (tmp_path / "crash.py").write_text("import os; os.abort()")
    given = np.zeros((1, 1, ARGUMENTS), dtype=np.float32)
    with pytest.raises(NoDevice, match="finds no device.*no screen.*make system"):
        Device("early").run(b"", given)
    with pytest.raises(NoDevice, match="said nothing"):
        Device("crash").run(b"", given)
    with pytest.raises(EcfitError, match="late failed .*bad code") as caught:
        Device("late").run(b"", given)
    assert not isinstance(caught.value, NoDevice)


def test_a_tool_without_a_device_compiles_only():
    nothing = Tool("nothing", "c", "library.c", (), None, "")
    found = check([shipped("conductor-7")], nothing, 64)
    assert found.agreements == ()
    assert found.worst is None
