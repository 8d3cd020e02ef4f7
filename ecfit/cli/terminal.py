"""What a command says beside its answer, which goes to stdout: progress and warnings."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from typing import Any

# Seconds between two lines of progress where there is no terminal, as in the log of a night.
LINES = 60.0
# The time that is left comes from the steps of this many seconds: of all, since a fit may take an hour, and
# with rich's 30 seconds there would be no estimate between two of them. What was on disk is one step, the
# first, which rich leaves out.
_MEMORY = 1e9


def bars(now: Callable[[], float] = time.monotonic) -> Any:
    """Progress bars with the time that is left; without a terminal, a line a minute and one at the end.

    Args:
        now: the clock, in seconds.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    class Bars:
        @contextmanager
        def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            console = Console(stderr=True)
            with Progress(*columns, console=console, speed_estimate_period=_MEMORY, get_time=now) as progress:
                progress.add_task(title, total=total)
                (task,) = progress.tasks
                said = now()

                def advance(steps: int) -> None:
                    nonlocal said
                    progress.advance(task.id, steps)
                    left = task.time_remaining
                    if not console.is_terminal and left and now() - said >= LINES:
                        said = now()
                        say(f"{title}: {task.completed:.0f} of {total}, {timedelta(seconds=int(left))} left")

                yield advance

    return Bars()


def say(text: str) -> None:
    print(text, file=sys.stderr)
