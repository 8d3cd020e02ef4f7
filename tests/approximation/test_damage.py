"""Files of fits and approximations: any damage is an `EcfitError`, wherever it is and whatever it holds."""

import copy
import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import ecfit
from ecfit.errors import EcfitError

# JSON's types, and numbers that fit into no 64 bits.
VALUES = [
    None,
    True,
    0,
    -1,
    1.5,
    1e308,
    10**400,
    "x",
    "",
    [],
    [[]],
    {},
    [1],
    [[1, 2], [3]],
    {"a": 1},
    [None],
    [10**400],
]


def places(data: Any, above: tuple = ()) -> Iterator[tuple]:
    """The path of every value."""
    if above:
        yield above
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from places(value, (*above, key))


def damaged(data: Any, place: tuple, value: Any) -> Any:
    out = copy.deepcopy(data)
    inner = out
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    return out


@pytest.fixture(scope="module")
def fit(make_table, unit_axis) -> ecfit.Fit:
    table = make_table(lambda r, mu: 1.0 + r * mu, unit_axis("r", 4), unit_axis("mu", 4))
    return ecfit.fit(table, ecfit.Polynomial(1))


def test_a_damaged_fit_is_an_error_or_still_a_fit(fit):
    data = json.loads(json.dumps(fit.to_dict()))
    refused = 0
    for place in places(data):
        for value in VALUES:
            try:
                ecfit.Fit.from_dict(damaged(data, place, value)).to_dict()
            except EcfitError:
                refused += 1
    assert refused > 500


def test_a_damaged_rational_is_an_error_or_still_evaluates():
    data = ecfit.published("sforza-pellacini-2022-conductor").to_dict()
    for place in places(data):
        if place[0] in ("numerator_exponents", "denominator_exponents", "domain", "variables"):
            for value in VALUES:
                try:
                    made = ecfit.Approximation.from_dict(damaged(data, place, value))
                except EcfitError:
                    continue
                points = [np.array([0.5])] * len(made.variables)
                assert np.asarray(made.at(points)).shape == (1,)


@pytest.mark.parametrize("exponent", [np.nan, np.inf, 1e30, -0.5])
def test_exponents_are_integers(exponent):
    data = ecfit.published("sforza-pellacini-2022-conductor").to_dict()
    with pytest.raises(EcfitError, match="exponents"):
        ecfit.Approximation.from_dict(damaged(data, ("numerator_exponents", 1, 0), exponent))


@pytest.mark.parametrize("data", [None, [], "fit", 3, {}])
def test_other_data_are_no_approximation(data):
    with pytest.raises(EcfitError):
        ecfit.Approximation.from_dict(data)
    with pytest.raises(EcfitError):
        ecfit.Fit.from_dict(data)
