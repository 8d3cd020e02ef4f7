"""What the studies of these tests share: fits in this process, and runs that draw nothing."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest

from ecfit.workers import ONE_THREAD


@pytest.fixture(scope="module", autouse=True)
def here() -> Iterator[None]:
    """Fits in this process, where each uses what XLA compiled for the last; undone by tests of workers."""
    with pytest.MonkeyPatch.context() as environment:
        for name, value in ONE_THREAD.items():
            environment.setenv(name, value)
        yield


@contextmanager
def without_report() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ecfit.report.write_report", lambda study: None)
        yield


@pytest.fixture(scope="session")
def unreported() -> Callable[[], AbstractContextManager[None]]:
    """`with unreported():` runs write no report: its figures take longer than all else in a small study."""
    return without_report


@pytest.fixture
def no_report() -> Iterator[None]:
    """The runs of a test write no report."""
    with without_report():
        yield
