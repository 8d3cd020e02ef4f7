"""Approximations made of others: variables of all, the domain where all are defined."""

import pytest

import ecfit
from ecfit.approximation import Written
from ecfit.approximation.approximation import Approximation
from ecfit.approximation.compose import compose
from ecfit.contract import Contract
from ecfit.errors import EcfitError


def part(name, variables, text, domain):
    formula = Written(variables, text)
    return Approximation(name, "written", "1", variables, formula, domain, Contract("unknown"))


E1 = part("e", ("mu", "alpha"), "1 - 0.3*alpha/(mu + 0.25)", ((0.0, 1.0), (0.0, 1.0)))
S = part("s", ("mu", "F0"), "F0 + (1 - F0)*(1 - mu)", ((0.0, 1.0), (0.01, 0.98)))


def test_values_variables_and_domain():
    made = compose("r", "E*S", {"E": E1, "S": S}, Contract("unknown"), {"F0": (0.0, 0.25)})
    assert made.variables == ("mu", "alpha", "F0")
    assert made.domain == ((0.0, 1.0), (0.0, 1.0), (0.01, 0.25))
    assert made.count == E1.count + S.count
    mu, alpha, f0 = 0.4, 0.3, 0.1
    expected = float(E1(mu=mu, alpha=alpha)) * float(S(mu=mu, F0=f0))
    assert float(made(mu=mu, alpha=alpha, F0=f0)) == pytest.approx(expected)
    again = Approximation.from_dict(made.to_dict(), "again")
    assert again.to_dict() == made.to_dict()


def test_what_does_not_fit_together_is_refused():
    with pytest.raises(EcfitError, match="parts of 'r' have no F0 in common"):
        compose("r", "E*S", {"E": E1, "S": S}, Contract("unknown"), {"F0": (0.99, 1.0)})
    table = ecfit.lookup_table("conductor", {"r": 3, "mu": 3})
    with pytest.raises(EcfitError, match="part 'E' is a lookup: only structured, written compose"):
        compose("r", "E*S", {"E": table, "S": S}, Contract("unknown"))
