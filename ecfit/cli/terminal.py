"""What a command says beside its answer, which goes to stdout: progress and warnings."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


def bars() -> Any:
    """Progress bars on the terminal (one line where there is none)."""
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
            with Progress(*columns, console=Console(stderr=True)) as progress:
                task = progress.add_task(title, total=total)
                yield lambda steps: progress.advance(task, steps)

    return Bars()


def say(text: str) -> None:
    print(text, file=sys.stderr)
