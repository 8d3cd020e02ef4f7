"""Forms to be certified."""

from collections.abc import Callable

import numpy as np
import pytest

from ecfit.approximation import Approximation
from ecfit.approximation.structured import StructuredFormula
from ecfit.approximation.written import Written
from ecfit.contract import Contract
from ecfit.forms import Structure, head

UNIT = (0.0, 1.0)


def structured(
    name: str,
    features: tuple,
    numerators: list,
    denominator: list,
    values: list,
    domain: dict,
    contract: Contract,
) -> Approximation:
    rows = tuple(np.array(n, dtype=float) for n in numerators)
    structure = Structure(head(name), features, rows, np.array(denominator, dtype=float))
    formula = StructuredFormula(structure, np.array(values))
    box = tuple(domain[v] for v in structure.variables)
    return Approximation(name, "structured", "", structure.variables, formula, box, contract)


def make_corner(values: list[float] | None = None) -> Approximation:
    """10 coefficients for the separable conductor: MAE 3.6e-4, largest error 2.3e-3 off-grid."""
    best = [.06256, .11125, .89389, .55689, -.57248, .20031, .17076, .32043, .36454, -.05526]  # fmt: skip
    return structured(
        "corner",
        ("alpha", "mu"),
        [[[1, 0], [0, 1], [3, 0], [2, 1], [3.5, 0], [0.5, 3]]],
        [[3, 0], [0, 3], [1.5, 1.5], [4.5, 1.5], [0.5, 3]],
        best if values is None else values,
        {"alpha": UNIT, "mu": UNIT},
        Contract("conductor", {"masking": "separable"}),
    )


def make_two_point() -> Approximation:
    """10 coefficients for a Fresnel layer."""
    two = [.21, -.21476, .88552, -1.0928, .11905, .20712, .0097354, .19291, .062069, .32762]  # fmt: skip
    return structured(
        "two-point",
        ("alpha", "mu"),
        [[[1, 0], [0, 1]], [[1, 0], [1, 1]], [[1, 0], [1, 1], [0, 1]]],
        [[2, 0], [1, 0], [0, 1], [0, 2]],
        two,
        {"alpha": UNIT, "mu": UNIT, "F0": (0.01, 0.9)},
        Contract("unknown"),
    )


def make_average() -> Approximation:
    """4 coefficients for the average albedo."""
    return structured(
        "average", ("r",), [[[0]]], [[0], [1], [3], [5]], [7.34344, 4.67508, 2.97394, 3.13255],
        {"alpha": UNIT}, Contract("unknown", quantity="average-albedo"),
    )  # fmt: skip


def make_written(
    text: str, names: tuple[str, ...] = ("r", "mu"), domain: tuple | None = None
) -> Approximation:
    box = domain or (UNIT,) * len(names)
    return Approximation("written", "written", "", names, Written(names, text), box, Contract("unknown"))


@pytest.fixture(scope="session")
def corner() -> Callable[..., Approximation]:
    return make_corner


@pytest.fixture(scope="session")
def two_point() -> Callable[..., Approximation]:
    return make_two_point


@pytest.fixture(scope="session")
def average() -> Callable[..., Approximation]:
    return make_average


@pytest.fixture(scope="session")
def written() -> Callable[..., Approximation]:
    return make_written
