"""The one error that ecfit raises for a user's mistake: what happened, and the remedy, in one line."""

import difflib
from collections.abc import Iterable, Mapping
from typing import Any


class EcfitError(Exception):
    """A mistake in what ecfit was given; the message is one line with its cause and remedy.

    The command line prints it and exits with code 2.
    """


def did_you_mean(name: str, valid: Iterable[str]) -> str:
    """`; did you mean 'x'?` for the valid name nearest to `name`, or nothing."""
    near = difflib.get_close_matches(str(name), list(valid), n=1, cutoff=0.6)
    return f"; did you mean '{near[0]}'?" if near else ""


def unknown(kind: str, name: object, valid: Iterable[str]) -> EcfitError:
    """The error for a name that is not registered: it lists the valid names."""
    valid = sorted(valid)
    return EcfitError(
        f"unknown {kind} '{name}': expected one of {', '.join(valid)}{did_you_mean(str(name), valid)}"
    )


def refuse_ignored(why: str, given: Mapping[str, Any]) -> None:
    """Raise `EcfitError` where something of what was given would have no effect: what is not None, nor empty.

    `why`: the beginning of the message, which ends with the names to leave out.
    """
    names = [k for k, v in given.items() if v is not None and not (isinstance(v, tuple | Mapping) and not v)]
    if names:
        raise EcfitError(f"{why}: leave out {', '.join(names)}")
