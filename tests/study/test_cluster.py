"""A study on a Dask cluster, interrupted, then with a worker killed: its bytes are those of a local run."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import kills
import pytest

import ecfit
from ecfit.progress import Progress

distributed = pytest.importorskip("distributed", reason="Dask distributed is not installed")
dask = pytest.importorskip("dask")

CONFIG = """
name = "small"
plugins = ["heads.py"]
[[tables]]
name = "separable"
model = "conductor"
axes = { r = 10, mu = 10 }
tolerance = 1e-5
[[tables]]
name = "correlated"
model = "conductor"
options = { masking = "height-correlated" }
axes = { r = 10, mu = 10 }
tolerance = 1e-5
[[tables]]
name = "given"
file = "e.csv"
axes = { r = 8, mu = 8 }
[[fits]]
tables = ["separable", "correlated", "given"]
form = "polynomial"
degree = [1, 2]
[[fits]]
tables = ["separable", "correlated", "given"]
form = "rational"
degree = [1, 2]
[[fits]]
tables = ["separable", "given"]
form = "module"
module = "saturating"
[report]
figures = []
"""

PLUGIN = """
import equinox as eqx
import jax
import jax.numpy as jnp
import ecfit


@ecfit.register_form("saturating")
class Saturating(eqx.Module):
    "1 minus a quotient."
    a: jax.Array

    def __init__(self):
        self.a = jnp.full(2, 0.5)

    def __call__(self, mu, r):
        return 1.0 - self.a[0] * r / (1.0 + self.a[1] * mu)
"""


class Counting(Progress):
    """Counts the fits, and calls a function after the first that is computed."""

    def __init__(self, after_one: Callable[[], object]) -> None:
        self.after_one = after_one
        self.steps: list[int] = []

    @contextmanager
    def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
        def advance(steps: int) -> None:
            if title == "fits":
                self.steps.append(steps)
                if len(self.steps) == 2:  # the first are those that are on disk
                    self.after_one()

        yield advance


@pytest.mark.slow
def test_a_study_on_a_cluster_that_is_interrupted_and_loses_a_worker(tmp_path: Path, no_report: None):
    config = kills.written(tmp_path).with_name("cluster.toml")
    config.write_text(CONFIG)
    (tmp_path / "heads.py").write_text(PLUGIN)
    ecfit.run(config, tmp_path / "local", workers=2)
    whole = kills.files(tmp_path / "local")
    settings = {"distributed.deploy.lost-worker-timeout": "5 minutes"}
    results = tmp_path / "cluster"
    with (
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=60
        ) as cluster,
    ):
        address = cluster.scheduler_address
        command = [sys.executable, "-c", "from ecfit.cli import main; main()", "run", str(config)]
        process = subprocess.Popen(
            [*command, "--results", str(results), "--scheduler", address],
            stderr=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        end = time.monotonic() + 240.0
        while (
            time.monotonic() < end and process.poll() is None and not list(results.glob("small/fits/*.json"))
        ):
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        assert process.returncode == 130, err
        assert "Traceback" not in err
        assert err.splitlines()[-1].startswith("stopped; what is finished is kept")
        kept = [name for name in kills.files(results) if "fits/" in name]
        assert 1 <= len(kept) < 14
        with distributed.Client(address, set_as_default=False) as client:
            victims = list(client.run(os.getpid).values())
        counting = Counting(lambda: os.kill(victims[0], signal.SIGKILL))
        done = ecfit.run(config, results, scheduler=address, progress=counting)
    fits = sum(map(len, done.fits.values()))
    assert fits == sum(counting.steps) == 14
    assert counting.steps[0] == len(kept)
    assert len(done.seconds) == fits - len(kept)  # each was computed once, as far as we know
    assert kills.files(results) == whole
