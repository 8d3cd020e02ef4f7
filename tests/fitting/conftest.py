"""A small problem that the tests of descents, norms and programs share: P / Q in mu on 120 nodes."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from ecfit.coordinates import Axis
from ecfit.fitting.descent import Descent
from ecfit.fitting.selection import descent_for
from ecfit.fitting.structured import domain_of
from ecfit.forms import Structure, head
from ecfit.tables import Table

MU = Axis.spaced("mu", 120)


class Curve(NamedTuple):
    """Terms 1, mu, ..., mu^3 in P and Q, and some of them as the support: Q's leading one is the first."""

    table: Table
    structure: Structure
    descent: Descent
    support: list[list[int]]


@pytest.fixture(scope="session")
def curve(make_table) -> Callable[..., Curve]:
    """`curve(f, numerator, denominator, head)`: a problem of f(mu); one shape, so that one program serves."""

    def made(
        f: Callable[[np.ndarray], Any], numerator: int = 2, denominator: int = 2, name: Any = "ratio"
    ) -> Curve:
        table = make_table(f, MU)
        rows = np.arange(4.0)[:, None]
        found = head(name) if isinstance(name, str) else name
        structure = Structure(found, ("mu",), (rows,) * found.ratios, rows)
        descent = descent_for(structure, table, domain_of(structure, table))
        support = [list(range(numerator)) for _ in range(found.ratios)] + [list(range(1, denominator))]
        return Curve(table, structure, descent, support)

    return made
