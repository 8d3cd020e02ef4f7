"""Error messages: one line that lists what is valid and guesses what was meant."""

from ecfit.errors import EcfitError, did_you_mean, unknown


def test_an_unknown_name_lists_the_valid_ones_in_order_and_suggests():
    error = unknown("spacing", "unifrom", ["uniform", "gauss"])
    assert isinstance(error, EcfitError)
    assert str(error) == "unknown spacing 'unifrom': expected one of gauss, uniform; did you mean 'uniform'?"


def test_nothing_is_suggested_where_nothing_is_near():
    assert did_you_mean("zzz", ["uniform", "gauss"]) == ""
    assert str(unknown("spacing", None, ["gauss"])) == "unknown spacing 'None': expected one of gauss"
