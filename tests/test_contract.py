"""Contracts: conventions as data, checked and read back."""

import json

import pytest

from ecfit.contract import LOBES, QUANTITIES, TRANSPORTS, Contract
from ecfit.errors import EcfitError

FULL = Contract(
    "conductor",
    {"ndf": "ggx", "masking": "separable"},
    {"F0": 1 / 3},
    "average-albedo",
    "reflection",
    "radiance",
    {"exponent": 5},
)


def test_a_contract_survives_json():
    assert Contract.from_dict(json.loads(json.dumps(FULL.to_dict()))) == FULL


def test_only_the_model_has_no_default():
    contract = Contract.from_dict({"model": "x"})
    assert (contract.quantity, contract.lobe, contract.transport) == ("directional-albedo", "all", "energy")
    assert (contract.stored, contract.sampling) == ("E", "true")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"quantity": "albedo"}, "unknown quantity 'albedo'"),
        ({"lobe": "reflected"}, "did you mean 'reflection'"),
        ({"transport": None}, "unknown transport"),
        ({"stored": "1 - E"}, "unknown stored value"),
        ({"sampling": ["true"]}, "unknown sampling"),
        ({"model": None}, "model"),
        ({"model": ["conductor"]}, "model"),
        ({"options": 5}, "options"),
        ({"options": ["ndf"]}, "options"),
        ({"parameters": "F0"}, "parameters"),
        ({"parameters": {"F0": "high"}}, "parameters"),
        ({"quantity_options": {"exponent": "five"}}, "quantity_options"),
        ({"quantity_options": {"exponent": True}}, "quantity_options"),
        ({"quantity_options": 5}, "quantity_options"),
        ({"colour": "red"}, "unknown contract key 'colour'"),
    ],
)
def test_unknown_conventions_are_refused(change, message):
    with pytest.raises(EcfitError, match=message):
        Contract.from_dict({"model": "conductor", **change})


@pytest.mark.parametrize("data", [None, [], "conductor", {}, {"options": {}}])
def test_other_data_are_no_contract(data):
    with pytest.raises(EcfitError, match="model"):
        Contract.from_dict(data)


def test_the_description_shows_every_convention():
    rows = dict(FULL.describe())
    assert rows["model"] == "conductor"
    assert rows["masking"] == "separable"
    assert rows["F0"] == "0.333333"
    assert rows["exponent"] == "5"
    assert rows["quantity"].startswith("average-albedo (")
    assert (rows["lobe"], rows["transport"], rows["sampling"]) == ("reflection", "radiance", "true")


@pytest.mark.parametrize("names", [QUANTITIES, LOBES, TRANSPORTS])
def test_every_name_is_explained(names):
    assert all(len(text) > 10 for text in names.values())
