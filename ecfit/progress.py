"""What long work tells while it runs. No JAX here."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Progress:
    """What a run tells while it works; this one says nothing. The command line shows bars."""

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        """A stage of `total` steps; the yielded function advances it."""
        yield lambda steps: None
