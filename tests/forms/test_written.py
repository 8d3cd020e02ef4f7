"""Formulas with free numbers: fitted, kept in files, and known to proofs."""

import numpy as np
import pytest

import ecfit
from ecfit._jax import jnp
from ecfit.approximation import Approximation
from ecfit.contract import Contract
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.expressions import cost
from ecfit.forms.modules import ModuleForm
from ecfit.forms.written import WrittenForm

SETTINGS = {
    "formula": "1 - p*a / (1 + c*mu)",
    "let": [["a", "alpha*alpha"]],
    "constants": {"p": 0.5, "c": 1.0},
    "variables": ["alpha", "mu"],
}


def table(p: float = 0.8, c: float = 2.0) -> ecfit.Table:
    r, mu = Axis.spaced("r", 9), Axis.spaced("mu", 11)
    values = 1.0 - p * r.nodes[:, None] ** 4 / (1.0 + c * mu.nodes)
    return ecfit.Table.from_array(values, {"r": r, "mu": mu}, Contract("conductor"))


def test_the_constants_are_found_in_another_view_of_the_coordinates():
    fit = ecfit.fit(table(), ModuleForm("written", SETTINGS))
    np.testing.assert_allclose(fit.coefficients, [0.8, 2.0], rtol=1e-7)
    assert fit.ok
    assert fit.approximation.variables == ("alpha", "mu")
    assert [label for label, _ in fit.approximation.formula.rows(("alpha", "mu"))] == ["p", "c"]


def test_a_file_gives_the_same_function_and_its_expression():
    made = ecfit.fit(table(), ModuleForm("written", SETTINGS)).approximation
    again = Approximation.from_dict(made.to_dict())
    point = {"alpha": 0.3, "mu": 0.4}
    assert float(again(**point)) == float(made(**point)) == pytest.approx(1.0 - 0.8 * 0.09 / 1.8, rel=1e-7)
    assert cost(again.expression()).divisions == 1


def test_poles_are_looked_for():
    """1 - 2 mu^2 vanishes between the nodes 0.7 and 0.8 of the domain."""
    form = WrittenForm("k / (1 - 2*mu*mu)", {"k": 1.0}, ["alpha", "mu"][1:])
    mu = Axis.spaced("mu", 11)
    values = 3.0 / (1.0 - 2.0 * mu.nodes**2)
    fit = ecfit.fit(ecfit.Table.from_array(values, {"mu": mu}, Contract("conductor")), form)
    assert fit.coefficients[0] == pytest.approx(3.0, rel=1e-6)
    assert not fit.ok


def test_a_variable_that_cancels_keeps_the_shape():
    form = WrittenForm("k * (mu + alpha - alpha)", {"k": 2.0}, ["alpha", "mu"])
    assert form(alpha=jnp.ones(3), mu=jnp.ones(3)).shape == (3,)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"constants": {}}, "needs constants"),
        ({"constants": {"p": 1.0, "c": 1.0, "q": 1.0}}, "'q' does not occur"),
        ({"variables": ["alpha", "mu", "mu"]}, "named twice"),
        ({"formula": "p*a + c*nu + mu"}, "unknown name 'nu'"),
    ],
)
def test_faults_are_named(changes, message):
    with pytest.raises(EcfitError, match=message):
        ModuleForm("written", {**SETTINGS, **changes})
