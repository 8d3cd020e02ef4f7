"""The BSDF interface: parameters, options and the mistakes that they refuse."""

import dataclasses

import pytest

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, Conductor, Lambertian
from ecfit.errors import EcfitError
from ecfit.quadrature import Hemisphere


class Least(BSDF):
    """A model with nothing but f."""

    def f(self, wo, wi):
        return jnp.asarray(0.0)


def test_f_is_all_that_a_model_needs():
    model = Least()
    assert isinstance(model.measure(), Hemisphere)
    assert model.exact_albedo(jnp.asarray(1.0)) is None
    assert model.active_parameters() == ()
    assert model.options() == {}
    assert float(model.relative_ior()) == 1.0


def test_a_model_without_f_cannot_be_made():
    class Empty(BSDF):
        pass

    with pytest.raises(TypeError, match="abstract"):
        Empty()  # pyright: ignore[reportAbstractUsage]


def test_parameters_become_float64_arrays():
    model = Lambertian(rho=1)  # pyright: ignore[reportArgumentType]
    assert isinstance(model.rho, jax.Array)
    assert model.rho.dtype == jnp.float64


def test_ranges_and_choices_come_from_the_fields():
    assert Conductor.parameter_ranges()["alpha"] == (0.0, 1.0)
    assert set(Conductor.parameter_ranges()) == {"alpha", "F0", "F90", "eta", "k", "tint"}
    assert Conductor.option_choices()["masking"] == ("separable", "height-correlated")
    assert Conductor().options() == {"ndf": "ggx", "masking": "separable", "fresnel": "unit"}


def test_every_parameter_and_option_says_what_it_is():
    for cls in ecfit.models().values():
        fields = {f.name: f for f in dataclasses.fields(cls)}
        for name in [*cls.parameter_ranges(), *cls.option_choices()]:
            assert len(fields[name].metadata["doc"]) > 5


def test_with_parameters_leaves_the_original_alone():
    model = Conductor()
    other = model.with_parameters({"alpha": jnp.asarray(0.75), "F0": jnp.asarray(0.5)})
    assert (float(other.alpha), float(other.F0)) == (0.75, 0.5)  # type: ignore[attr-defined]
    assert (float(model.alpha), float(model.F0)) == (0.25, 1.0)
    assert model.with_parameters({}) is model


def test_with_parameters_takes_tracers():
    slope = jax.grad(lambda r: Lambertian().with_parameters({"rho": r}).f(*[jnp.array([0.0, 0.0, 1.0])] * 2))
    assert float(slope(0.5)) == pytest.approx(1.0 / jnp.pi)


def test_with_parameters_refuses_unknown_names():
    with pytest.raises(EcfitError, match="unknown parameter 'alhpa'.*did you mean 'alpha'"):
        Conductor().with_parameters({"alhpa": jnp.asarray(0.5)})


@pytest.mark.parametrize("value", ["GGX", "", 3, None, []])
def test_an_option_is_one_of_its_words(value):
    with pytest.raises(EcfitError, match="expected one of beckmann, ggx"):
        Conductor(ndf=value)


@pytest.mark.parametrize(("low", "high"), [(-0.1, 0.5), (0.5, 1.1), (float("nan"), float("nan"))])
def test_a_range_outside_the_parameters_is_refused(low, high):
    with pytest.raises(EcfitError, match=r"'alpha' of Conductor lies in \[0, 1\]"):
        Conductor().check_range("alpha", low, high)


def test_the_full_range_is_allowed():
    Conductor().check_range("alpha", 0.0, 1.0)
