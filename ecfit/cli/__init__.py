"""The command line, a file a theme.

Help loads no command; a command loads its own file, and JAX when nothing was mistaken before that needs it.
"""

import os
import sys
from typing import NoReturn

from ecfit.cli.overview import RESUMED, asks_for_page, page
from ecfit.errors import EcfitError

# Before NumPy loads: JAX has a pool of threads of its own, and where two pools share the cores small
# factorisations take up to a hundred times longer (docs/performance.md).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main(arguments: list[str] | None = None) -> None:
    """Entry point: a mistake is one message and exit code 2; an interrupt says how to go on (130)."""
    words = sys.argv[1:] if arguments is None else arguments
    try:
        if asks_for_page(words):
            print(page())
        elif words == ["--version"]:
            from ecfit import __version__

            print(__version__)
        else:
            _call(words)
        sys.stdout.flush()  # a pipe that was closed is met here, not when Python ends
    except EcfitError as error:
        _fail(f"error: {error}")
    except KeyboardInterrupt:
        kept = "; what is finished is kept: the same command goes on from here"
        _fail(f"stopped{kept if words[:1] and words[0] in RESUMED else ''}", 130)
    except MemoryError:
        _fail("error: out of memory: use fewer nodes an axis")
    except BrokenPipeError:
        # Nothing is left to flush to: Python would say so at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(0) from None


def _call(words: list[str]) -> None:
    """What the above does without: the folder of compiled code, and cyclopts (0.2 s)."""
    from ecfit._cache import keep_compiled
    from ecfit.cli.app import call

    keep_compiled()
    call(words)


def _fail(text: str, code: int = 2) -> NoReturn:
    print(text, file=sys.stderr)
    raise SystemExit(code)
