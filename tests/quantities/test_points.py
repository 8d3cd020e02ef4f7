"""From coordinates to parameters."""

import pytest

import ecfit
from ecfit.errors import EcfitError
from ecfit.quantities import AverageAlbedo, DirectionalAlbedo, parameter_map

CONDUCTOR = ecfit.model("conductor", fresnel="schlick")


def test_a_view_leads_to_its_parameter_and_a_parameter_to_itself():
    parameter, map_ = parameter_map(CONDUCTOR, DirectionalAlbedo(), "r")
    assert (parameter, map_.forward(0.5)) == ("alpha", 0.25)
    # The conductor's own F0 is Schlick's, not a view of an index that it does not have.
    parameter, map_ = parameter_map(CONDUCTOR, DirectionalAlbedo(), "F0")
    assert (parameter, map_.forward(0.5)) == ("F0", 0.5)


def test_mu_belongs_to_the_quantity():
    assert parameter_map(CONDUCTOR, DirectionalAlbedo(), "mu")[0] == "mu"
    with pytest.raises(EcfitError, match="no coordinate 'mu'"):
        parameter_map(CONDUCTOR, AverageAlbedo(), "mu")


def test_a_parameter_without_effect_says_which_options_made_it_so():
    with pytest.raises(EcfitError, match="'eta' has no effect with .*fresnel = schlick"):
        parameter_map(CONDUCTOR, DirectionalAlbedo(), "eta")
