"""Models by name."""

import pytest

import ecfit
from ecfit.bsdf import BSDF, Conductor, Lambertian, as_model
from ecfit.bsdf.registry import _MODELS, name_of
from ecfit.errors import EcfitError


class Mine(Lambertian):
    """A user's model."""


@pytest.fixture(autouse=True)
def restored():
    """The registry as it was."""
    before = dict(_MODELS)
    yield
    _MODELS.clear()
    _MODELS.update(before)


def test_shipped_models_are_registered():
    assert ecfit.models()["conductor"] is Conductor
    assert ecfit.models()["lambertian"] is Lambertian


def test_settings_are_options_and_parameters():
    model = ecfit.model("conductor", masking="height-correlated", alpha=0.5)
    assert isinstance(model, Conductor)
    assert model.masking == "height-correlated"
    assert float(model.alpha) == 0.5


def test_a_registered_model_is_found_by_name_and_named_by_it():
    ecfit.register("mine")(Mine)
    assert isinstance(ecfit.model("mine", rho=0.5), Mine)
    assert name_of(Mine()) == "mine"


def test_registering_a_users_name_again_replaces_it():
    class Mine2(Lambertian):
        pass

    ecfit.register("mine")(Mine)
    ecfit.register("mine")(Mine2)
    assert isinstance(ecfit.model("mine"), Mine2)


def test_a_shipped_name_cannot_be_taken():
    with pytest.raises(EcfitError, match="'conductor' is taken"):
        ecfit.register("conductor")(Mine)
    assert ecfit.models()["conductor"] is Conductor


@pytest.mark.parametrize("what", [int, 3, lambda: None])
def test_only_models_are_registered(what):
    with pytest.raises(EcfitError, match="subclass of ecfit.BSDF"):
        ecfit.register("mine")(what)


def test_the_listing_is_a_copy():
    ecfit.models()["fake"] = Mine
    assert "fake" not in ecfit.models()


def test_an_unknown_model_lists_the_known_ones_and_suggests():
    with pytest.raises(EcfitError, match=r"conductor.*lambertian.*did you mean 'conductor'"):
        ecfit.model("conductr")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"maskng": "separable"}, "no setting 'maskng'.*did you mean 'masking'"),
        ({"masking": "correlated"}, "expected one of height-correlated, separable"),
        ({"alpha": "0.5"}, "'alpha' of model 'conductor' must be a number"),
        ({"alpha": True}, "must be a number"),
        ({"alpha": 1.5}, r"lies in \[0, 1\]"),
        ({"alpha": float("nan")}, r"lies in \[0, 1\]"),
        ({"roughness": 0.5}, "no setting 'roughness'"),
    ],
)
def test_bad_settings_are_refused(settings, message):
    with pytest.raises(EcfitError, match=message):
        ecfit.model("conductor", **settings)


def test_a_model_may_be_given_as_itself_its_class_or_its_name():
    instance = Conductor()
    assert as_model(instance) is instance
    assert isinstance(as_model(Conductor), Conductor)
    assert isinstance(as_model("conductor"), Conductor)


@pytest.mark.parametrize("what", [None, 3, int, object()])
def test_anything_else_is_no_model(what):
    with pytest.raises(EcfitError, match="expected a BSDF"):
        as_model(what)


def test_an_unregistered_model_goes_by_its_class():
    class Nameless(BSDF):
        def f(self, wo, wi):
            return wi[2]

    assert name_of(Nameless()) == "Nameless"
