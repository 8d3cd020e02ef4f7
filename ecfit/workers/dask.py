"""Tasks on the workers of a Dask scheduler (https://distributed.dask.org). No JAX here."""

import logging
import math
import pickle
import time
import uuid
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from typing import Any

from ecfit.errors import EcfitError
from ecfit.files import write_json
from ecfit.workers.job import Job
from ecfit.workers.remote import TOPIC, build, check

try:
    import dask
    import distributed
    from distributed.scheduler import KilledWorker
    from distributed.versions import VersionMismatchWarning
except ImportError:
    raise EcfitError(
        "a scheduler needs Dask distributed, here and on the workers: pip install 'ecfit[distributed]'"
    ) from None

# Seconds for a scheduler to answer; Dask's own default is 30 with a pool of retries in them.
ANSWER = 10.0
# Seconds for the first worker to join: one that was started just before loads Dask twice.
JOIN = 30.0
# Seconds without any worker after which a run ends: long enough for a nanny to start one again, or a queue.
LONELY = 120.0
# Seconds for the result of a task, some 100 kB, to come from its worker: where that died just after the task,
# nobody answers, and the scheduler gives the task to another one.
FETCH = 30.0
# Seconds between two looks at whether the cluster is still there.
_PATIENCE = 1.0


@contextmanager
def connected(address: str) -> Iterator["Dask"]:
    """The engine of the scheduler at an address, such as "tcp://host:8786".

    At the end the cluster goes on; what this run has there is cancelled. Raises `EcfitError` where no
    scheduler answers, no worker joins, or a worker would not compute what this process does.
    """
    with _quiet():
        try:
            client = distributed.Client(address, timeout=ANSWER, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
            raise EcfitError(
                f"no Dask scheduler answers at '{address}' ({_line(error)}): start one with `dask scheduler` "
                "and give the address that it prints, tcp://host:8786"
            ) from None
        try:
            engine = Dask(client, address)
            engine.check()
            yield engine
        finally:
            with suppress(Exception):
                client.close(timeout=ANSWER)


@contextmanager
def _quiet() -> Iterator[None]:
    """One line for a fault, ours: Dask would log many. It also warns of versions (`check` tells them) and of
    tasks above 10 MB, which a table may be."""
    logger = logging.getLogger("distributed")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    limit = {"distributed.admin.large-graph-warning-threshold": "1 TB"}
    try:
        with warnings.catch_warnings(), dask.config.set(limit):
            warnings.simplefilter("ignore", VersionMismatchWarning)
            yield
    finally:
        logger.setLevel(level)


def _by_value() -> Callable[..., Any]:
    """`remote.call`, to be sent with its code: a scheduler unpickles it too, and needs no ecfit then."""

    def ecfit_task(*arguments: Any) -> Any:
        from ecfit.workers.remote import call

        return call(*arguments)

    return ecfit_task


def _line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


class Dask:
    """An `Engine`: the workers of a scheduler, one thread each. Files are written by this process.

    A task whose worker died is given to another by the scheduler, as often as its `allowed-failures` says.
    """

    def __init__(self, client: "distributed.Client", address: str) -> None:
        self.client = client
        self.address = address

    def check(self) -> None:
        """Raise `EcfitError` unless there are workers, and all would compute what this process does."""
        try:
            self.client.wait_for_workers(1, timeout=JOIN)
            found: Any = self.client.run(check, build(), on_error="return")
        except TimeoutError:
            raise EcfitError(
                f"the Dask scheduler at '{self.address}' has no workers: start some with "
                f"`OPENBLAS_NUM_THREADS=1 dask worker {self.address} --nthreads 1`"
            ) from None
        except (OSError, RuntimeError) as error:
            raise self._gone(error) from None
        for worker, fault in found.items():
            if isinstance(fault, EcfitError):
                raise fault
            if isinstance(fault, BaseException):
                raise EcfitError(
                    f"worker {worker} cannot run ecfit ({_line(fault)}): install 'ecfit[distributed]' there"
                )

    def threads(self) -> int:
        """How many tasks can run at once now. Raises `EcfitError` where the scheduler is gone."""
        try:
            if self.client.status == "running":
                threads: Any = self.client.nthreads()
                return sum(threads.values())
        except (OSError, RuntimeError) as error:
            raise self._gone(error) from None
        raise self._gone("the connection is lost")

    def _gone(self, error: object) -> EcfitError:
        return EcfitError(
            f"the Dask scheduler at '{self.address}' is gone ({error}); what is finished is kept: with a "
            "scheduler again the same command goes on from here"
        )

    def run(self, job: Job, done: Callable[[int, Any], object], heard: Callable[[Any], object]) -> None:
        """See `Engine`."""
        if not job.tasks:
            return
        run = uuid.uuid4().hex
        wanted, prepare = build(), pickle.dumps(job.prepare)
        task = _by_value()
        # Events and ended futures, from Dask's threads to this one.
        inbox: SimpleQueue[Any] = SimpleQueue()
        queue = deque(job.order)
        running: dict[distributed.Future, int] = {}
        # How many messages of a task have been handled: of a task that is done again, none is twice.
        handled: Counter[int] = Counter()

        def hear(index: int, number: int, message: bytes) -> None:
            if number != handled[index]:
                return  # heard before, or after one that was lost and comes with the result
            handled[index] += 1
            kind, *content = pickle.loads(message)
            (write_json if kind == "keep" else heard)(*content)

        def listen(event: tuple[float, dict[str, Any]]) -> None:
            if event[1]["run"] == run:
                inbox.put(event[1])

        self.client.subscribe_topic(TOPIC, listen)
        try:
            room = _Room(self)
            while queue or running:
                # No more than can run: those that only wait on a worker would be blamed for its end, and
                # each has its table with it.
                while queue and len(running) < room.look():
                    index = queue.popleft()
                    future = self.client.submit(
                        task, run, index, wanted, prepare, job.pickled(index),
                        key=f"ecfit-{run}-{index}", pure=False,
                    )  # fmt: skip
                    running[future] = index
                    future.add_done_callback(inbox.put)
                try:
                    item = inbox.get(timeout=_PATIENCE)
                except Empty:
                    room.look()
                    continue
                if isinstance(item, dict):
                    hear(item["task"], item["number"], item["message"])
                    continue
                index = running[item]
                found = self._result(item, job, index)
                if found is None:
                    item.add_done_callback(inbox.put)
                    room.look()
                    continue
                del running[item]
                result, said = found
                for number, message in enumerate(said):
                    hear(index, number, message)
                done(index, result)
        finally:
            with suppress(Exception):
                self.client.cancel(list(running))
            with suppress(Exception):
                self.client.unsubscribe_topic(TOPIC)

    def _result(self, future: Any, job: Job, index: int) -> tuple[Any, list[bytes]] | None:
        """What a task returned and said; None where its worker does not answer. Raises what it raised."""
        # That is here already: a `TimeoutError` is then the task's own.
        failed = future.status == "error"
        try:
            return future.result(timeout=None if failed else FETCH)
        except TimeoutError:
            if failed:
                raise
            return None
        except KilledWorker as error:
            raise job.deadly(
                index, error.allowed_failures + 1, f"the last was {error.last_worker.address}"
            ) from None
        except distributed.CancelledError:
            raise self._gone("the connection is lost, or another client cancelled the tasks") from None


class _Room:
    """How many tasks can run at once: workers come and go during a run."""

    def __init__(self, engine: Dask) -> None:
        self.engine = engine
        self.count = 0
        self.looked = -math.inf
        self.seen = time.monotonic()

    def look(self) -> int:
        """The number of threads, at most `_PATIENCE` old. Raises `EcfitError` after `LONELY` seconds at 0."""
        now = time.monotonic()
        if now - self.looked >= _PATIENCE:
            self.count, self.looked = self.engine.threads(), now
        if self.count:
            self.seen = now
        elif now - self.seen > LONELY:
            raise EcfitError(
                f"the Dask scheduler at '{self.engine.address}' has had no workers for {LONELY:g} "
                "seconds; what is finished is kept: with workers again the same command goes on from here"
            )
        return self.count
