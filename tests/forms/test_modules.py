"""Forms that are a user's own Equinox module: what is accepted, how files name it, what is refused."""

import json

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import ecfit
from ecfit.approximation import ModuleFormula
from ecfit.errors import EcfitError
from ecfit.forms import ModuleForm, form, registered_forms
from ecfit.forms.modules import (
    Record,
    coefficients_of,
    coordinates_of_module,
    labels_of,
    make_module,
    with_coefficients,
)


@ecfit.register_form("test-line")
class Line(eqx.Module):
    """a + b mu^power, with more settings than coefficients."""

    a: jax.Array
    b: jax.Array
    index: jax.Array
    power: int = eqx.field(static=True)

    def __init__(self, power: int = 1) -> None:
        if power < 1:
            raise EcfitError("power must be 1 or more")
        self.a, self.b = jnp.asarray(0.5), jnp.zeros(1, dtype=jnp.float32)
        self.index, self.power = jnp.arange(3), power

    def __call__(self, **coordinates):
        return self.a + self.b[0] * coordinates["mu"] ** self.power


@ecfit.register_form("test-made")
def made(power: int = 2) -> Line:
    """A function that makes a module."""
    return Line(power)


class Unregistered(eqx.Module):
    a: jax.Array = eqx.field(default=0.5, converter=jnp.asarray)

    def __call__(self, mu, alpha):
        return self.a * mu + alpha


def test_coefficients_are_the_inexact_arrays_in_float64():
    module = Line(3)
    assert coefficients_of(module).tolist() == [0.5, 0.0]
    assert coefficients_of(module).dtype == np.float64
    assert labels_of(module) == ["a", "b[0]"]
    other = with_coefficients(module)(jnp.array([2.0, 3.0]))
    assert (float(other.a), other.power, other.index.tolist()) == (2.0, 3, [0, 1, 2])
    assert float(other(mu=jnp.asarray(2.0))) == 26.0


def test_a_form_by_name_is_made_of_its_settings():
    by_name = form("module", module="test-line", settings={"power": 2})
    assert isinstance(by_name, ModuleForm)
    assert (by_name.name, by_name.degree, by_name.count(1)) == ("test-line", "2", 2)
    assert ModuleForm(Line()).name == "test-line"
    assert ModuleForm(Unregistered()).name == "Unregistered"
    assert {"test-line", "test-made", "learned-rational"} <= set(registered_forms())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ModuleForm("test-lime"), "plugin.*did you mean 'test-line'"),
        (lambda: ModuleForm("test-line", {"powr": 2}), r"cannot be made of the settings \{'powr': 2\}"),
        (lambda: ModuleForm("test-line", {"power": 0}), "'test-line': power must be 1 or more"),
        (lambda: ModuleForm(Line(), {"power": 2}), "settings belong to the name"),
        (lambda: ModuleForm(3.0), "must be an equinox.Module with __call__, got float"),
        (lambda: ModuleForm(eqx.tree_at(lambda m: m.a, Line(), jnp.asarray(1j))), "complex"),
        (lambda: ModuleForm(eqx.tree_at(lambda m: m.a, Line(), jnp.asarray(jnp.nan))), "not finite"),
        (lambda: ecfit.register_form("a b")(Line), "a name is a word"),
        (lambda: ecfit.register_form("x")(int), "expects an equinox.Module class"),
        (lambda: ecfit.register_form("learned-rational")(Line), "taken by ecfit"),
        (lambda: make_module("learned-rational", {"degree": 0}), "degree must be in 1..20"),
    ],
)
def test_what_is_no_module_is_refused(call, message):
    with pytest.raises(EcfitError, match=message):
        call()


def test_coordinates_are_those_that_the_call_names():
    assert coordinates_of_module(Line(), ("r", "mu")) == ("r", "mu")
    assert coordinates_of_module(Unregistered(), ("r", "mu")) == ("mu", "alpha")
    with pytest.raises(EcfitError, match="function of mu, alpha: the table has F0, mu"):
        coordinates_of_module(Unregistered(), ("F0", "mu"))


@pytest.mark.parametrize("given", [Line(3), ModuleForm("test-made", {"power": 3})])
def test_a_file_names_the_module_and_gives_it_back(given):
    wrapped = given if isinstance(given, ModuleForm) else ModuleForm(given)
    module = with_coefficients(wrapped.module())(jnp.array([0.1, 0.7]))
    formula = ModuleFormula(module, ("mu",), wrapped.record(module, ("mu",)))
    data = json.loads(json.dumps(formula.to_dict()))
    assert data == {"module": wrapped.name, "settings": {"power": 3}, "coefficients": [0.1, 0.7]}
    again = ModuleFormula.from_dict({**data, "variables": ["mu"]}, 1)
    mu = np.linspace(0.0, 1.0, 5)
    assert np.array_equal(again.value([mu]), formula.value([mu]))


def test_files_of_what_is_not_registered_are_refused_with_the_remedy():
    module = Unregistered()
    formula = ModuleFormula(module, ("mu", "alpha"), ModuleForm(module).record(module, ("mu", "alpha")))
    with pytest.raises(EcfitError, match="cannot be saved: decorate"):
        formula.to_dict()
    with pytest.raises(EcfitError, match="no module form 'theirs' is registered: name the plugin"):
        Record("theirs", {}).made(np.zeros(1))
    with pytest.raises(EcfitError, match="has 2 coefficients, 3 are given: its code is not"):
        Record("test-line", {}).made(np.zeros(3))


def test_a_module_whose_settings_nobody_knows_is_not_written():
    @ecfit.register_form("test-hidden")
    class Hidden(eqx.Module):
        a: jax.Array
        kept: float = eqx.field(static=True)

        def __init__(self, power: float = 1.0) -> None:
            self.a, self.kept = jnp.asarray(1.0), 2.0 * power

        def __call__(self, mu):
            return self.a * mu**self.kept

    assert ModuleForm(Hidden(2.0)).record(Hidden(2.0), ("mu",)) is None
    assert ModuleForm("test-hidden", {"power": 2.0}).record(Hidden(2.0), ("mu",)) is not None


def test_a_formula_has_numpy_out_for_numpy_in_and_no_expression():
    formula = ModuleFormula(Line(), ("mu",))
    assert isinstance(formula.value([np.array([0.5])]), np.ndarray)
    assert isinstance(formula.value([jnp.array([0.5])]), jax.Array)
    assert formula.rows(("mu",)) == [("a", 0.5), ("b[0]", 0.0)]
    assert formula.smallest_denominator([(0.0, 1.0)]) == (1.0, (0.0,), 1.0)
    with pytest.raises(EcfitError, match="has no expression: it cannot be certified or exported"):
        formula.expression(("mu",))
