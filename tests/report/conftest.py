"""What the tests of reports share: small tables made here, and a study of three dimensions written once."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.config import StudyConfig
from ecfit.metrics import measure
from ecfit.report import write_report
from ecfit.study import Study


def smooth(*counts: int) -> ecfit.Table:
    """1 / (1 + x + y + ...) on axes in [0, 1]: the last is mu, before it r, then F0."""
    names = ("F0", "r", "mu")[3 - len(counts) :]
    axes = tuple(ecfit.Axis.spaced(n, c) for n, c in zip(names, counts, strict=True))
    mesh = np.meshgrid(*[a.nodes for a in axes], indexing="ij")
    values = np.asarray(1.0 / (1.0 + sum(mesh)))
    zeros = np.zeros_like(values)
    return ecfit.Table(values, zeros + 1e-9, zeros, axes, ecfit.Contract("synthetic"), 1e-8)


def judged_study(folder: Path, table: ecfit.Table, figures: tuple[str, ...] = ()) -> Study:
    """A study of one table, two fits, and a "published" approximation and a look-up table beside them."""
    fits = [ecfit.fit(table, ecfit.Polynomial(d)) for d in (1, 2)]
    printed = dataclasses.replace(fits[0].approximation, name="printed-2022", source="a paper")
    beside = [printed, ecfit.Approximation.lookup(table)]
    config = StudyConfig.model_validate({
        "name": "page", "tables": [{"name": "e", "model": "conductor", "axes": {"r": 4, "mu": 4}}],
        "report": {"figures": list(figures)},
    })  # fmt: skip
    return Study(config, folder, {"e": table}, {"e": fits}, {"e": [(a, measure(a, table)) for a in beside]})


@pytest.fixture(scope="session")
def make_smooth() -> Callable[..., ecfit.Table]:
    """`make_smooth(*counts)`: a smooth table of one to three dimensions."""
    return smooth


@pytest.fixture(scope="session")
def solid(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study of a table F0 x r x mu, its report written."""
    study = judged_study(tmp_path_factory.mktemp("solid"), smooth(5, 6, 7), figures=("svg",))
    write_report(study)
    return study
