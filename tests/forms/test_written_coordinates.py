"""Written forms that neglect a coordinate of their table."""

import numpy as np
import pytest

import ecfit
from ecfit.errors import EcfitError
from ecfit.forms.written import WrittenForm


def test_a_formula_may_neglect_a_coordinate(make_table, unit_axis):
    """The best constant factor of a table that does depend on it."""
    table = make_table(lambda mu, alpha: mu * (1.0 + alpha), unit_axis("mu", 9), unit_axis("alpha", 9))
    fit = ecfit.fit(table, WrittenForm("k*mu", {"k": 1.0}, ["mu", "alpha"]))
    assert fit.coefficients == pytest.approx([1.5], abs=1e-6)
    found = np.asarray(fit(mu=0.5, alpha=np.array([0.0, 1.0])))
    np.testing.assert_allclose(found, 0.75, atol=1e-6)


def test_a_constant_that_does_not_occur_is_refused():
    with pytest.raises(EcfitError, match="'j' does not occur in the formula"):
        WrittenForm("k*mu", {"k": 1.0, "j": 2.0}, ["mu"])
