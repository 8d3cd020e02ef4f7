"""What the tests of hostile input share: wrong values for every place, and a guard that sees what is done.

The guard is an audit hook (PEP 578): it sees every file that Python opens for writing, makes, moves or
removes, every process that is started, and every object that pickle would look up, whoever does it.
"""

import copy
import os
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ecfit.errors import EcfitError

# A place that no test may write to, by its whole path and from a folder deep enough.
OUTSIDE = str(Path(tempfile.gettempdir()).resolve() / "ecfit-escaped")
UPWARDS = "../" * 16 + OUTSIDE.lstrip("/")

TEXTS = [
    "", " ", "x", "../x", UPWARDS, OUTSIDE, "..", ".", "a/b", "a\\b",
    "~", "a\x00b", "a\nb", "\ud7ff", "\U0001f600", "'; DROP", "<script>alert(1)</script>",
    '"><img src=x onerror=y>',
    "$\\frac{$", "$x_$", "{{ 7 * 7 }}", "%s%n", "x" * 5000, "__class__", "constructor", "CON", "-", "--help",
    "__import__('os').system('touch ecfit-escaped')", "r", "mu", "F0", "alpha", "ior", "E", "1-E",
    "x/0", "2**99999", "9**9**9", "1e999", "exp(1e9)", "log(-1)", "sqrt(-mu)", "(" * 300, "-" * 900 + "1",
    "mu" + "+mu" * 4000, "nan", "inf", "None", "lambda: 0", "mu if mu else 1", "mu.real", "(mu := 1)",
]  # fmt: skip

NUMBERS = [
    0, 1, -1, 2, 3, 7, 64, 65, 2**31, 2**63, 2**64, -(2**63), 10**400, 0.0, -0.0, 0.5, 1.5, -2.5, 1e-320,
    1e30, 1e308, -1e308, float("nan"), float("inf"), float("-inf"), True, False,
]  # fmt: skip

values = st.one_of(
    st.sampled_from(TEXTS),
    st.sampled_from(NUMBERS),
    st.none(),
    st.text(max_size=20),
    st.floats(),
    st.integers(),
    st.recursive(
        st.sampled_from([*TEXTS[:6], *NUMBERS[:12], None]),
        lambda inner: st.one_of(
            st.lists(inner, max_size=4),
            st.dictionaries(st.sampled_from(["a", "mu", "r", "", "name", "count"]), inner, max_size=3),
        ),
        max_leaves=8,
    ),
)

# One change: where (a part of all places), what is done there, and the value for it.
changes = st.lists(
    st.tuples(
        st.floats(0.0, 1.0, exclude_max=True),
        st.sampled_from(["put", "put", "remove", "copy", "add"]),
        values,
    ),
    min_size=1,
    max_size=3,
)


def places(data: Any, above: tuple = ()) -> Iterator[tuple]:
    """The path of every value inside `data`."""
    if above:
        yield above
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from places(value, (*above, key))


def changed(data: Any, made: list[tuple[float, str, Any]]) -> Any:
    """A copy of plain data with changes."""
    out = copy.deepcopy(data)
    for part, what, value in made:
        found = list(places(out))
        if not found:
            return value
        place = found[int(part * len(found))]
        inside = out
        for key in place[:-1]:
            inside = inside[key]
        key = place[-1]
        if what == "put":
            inside[key] = value
        elif what == "remove":
            del inside[key]
        elif what == "copy" and isinstance(inside, list):
            inside.insert(key, copy.deepcopy(inside[key]))
        elif isinstance(inside, dict):
            inside[value if isinstance(value, str) else f"{key}x"] = copy.deepcopy(inside[key])
    return out


# Damage of a file: bytes replaced, and where it is cut.
damages = st.tuples(
    st.lists(st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.integers(0, 255)), max_size=6),
    st.one_of(st.just(1.0), st.just(1.0), st.floats(0.0, 1.0)),
)


def damaged(good: bytes, damage: tuple[list[tuple[float, int]], float]) -> bytes:
    out = bytearray(good)
    for part, byte in damage[0]:
        out[int(part * len(out))] = byte
    return bytes(out[: int(damage[1] * len(out))])


class _Guard:
    """The state of the audit hook, which cannot be removed again."""

    folder = ""
    active = False
    seen: list[str] = []  # noqa: RUF012


def settled(call: Callable[[], object], seconds: float = 20.0) -> bool:
    """Whether a call ended well; false where it ended in an `EcfitError` of lines that can be printed.

    Any other exception is the test's failure, and so is a call that takes more than so many seconds of this
    process's time, or thirty times as many of anybody's.
    """

    def late(*_: Any) -> None:
        raise AssertionError(f"a case takes more than {seconds} s")

    # Time of this process first: on a busy machine a second of it may be a minute.
    timers = (
        (signal.SIGVTALRM, signal.ITIMER_VIRTUAL, seconds),
        (signal.SIGALRM, signal.ITIMER_REAL, 30 * seconds),
    )
    old = [signal.signal(number, late) for number, _, _ in timers]
    for _, timer, limit in timers:
        signal.setitimer(timer, limit)
    _Guard.active = True
    try:
        call()
    except EcfitError as error:
        if not str(error).strip():
            raise AssertionError("an error without a message") from error
        return False
    finally:
        _Guard.active = False
        for (number, timer, _), handler in zip(timers, old, strict=True):
            signal.setitimer(timer, 0.0)
            signal.signal(number, handler)
    return True


# Events whose first argument is a path that is changed.
_WRITES = (
    "os.mkdir",
    "os.remove",
    "os.rmdir",
    "os.truncate",
    "os.link",
    "os.symlink",
    "os.chmod",
    "os.rename",
)
_STARTS = (
    "subprocess.Popen",
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "os.fork",
    "pickle.find_class",
    "socket.connect",
)


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if not (_Guard.active and _Guard.folder):
        return
    if event in _STARTS:
        _Guard.seen.append(f"{event} {arguments!r}")
        return
    if event == "open":
        path, mode, flags = arguments
        writes = (
            bool(flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))
            if isinstance(flags, int)
            else "w" in str(mode)
        )
        if not writes:
            return
    elif event in _WRITES:
        path = arguments[0]
    else:
        return
    if isinstance(path, int):
        return
    real = os.path.realpath(os.fsdecode(path))
    if real != os.devnull and not real.startswith((_Guard.folder, os.path.realpath(sys.prefix) + os.sep)):
        _Guard.seen.append(f"{event} {real}")


sys.addaudithook(_hook)


@contextmanager
def guarded(folder: Path) -> Iterator[None]:
    """Fail where a `settled` call writes outside `folder`, starts a process or unpickles an object."""
    _Guard.folder, _Guard.seen = os.path.realpath(folder), []
    # A module of ours that a case is the first to need would be kept compiled, beside its source.
    keeps, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        yield
    finally:
        _Guard.folder, sys.dont_write_bytecode = "", keeps
    if _Guard.seen:
        raise AssertionError("\n".join(_Guard.seen))


def many(fast: int, slow: int) -> pytest.MarkDecorator:
    """The number of cases: few in every run, many in `make test-all`."""
    return pytest.mark.parametrize("cases", [fast, pytest.param(slow, marks=pytest.mark.slow)])


def tried(cases: int, strategy: st.SearchStrategy[Any], case: Callable[[Any], object]) -> None:
    """Run `case` on so many examples."""

    @settings(max_examples=cases, database=None, suppress_health_check=list(HealthCheck))
    @given(strategy)
    def run(example: Any) -> None:
        case(example)

    run()
