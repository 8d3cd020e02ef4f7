"""Shipped fits: each file loads, evaluates and says what it approximates; unknown names are told."""

import numpy as np
import pytest

import ecfit
from ecfit.approximation import shipped as module_function
from ecfit.files import write_json


def test_every_shipped_fit_loads_and_has_a_positive_denominator():
    names = ecfit.shipped()
    assert names == sorted(names)
    for name in names:
        found = ecfit.shipped(name)
        assert found.contract.model != "unknown"
        middle = {v: 0.5 * (low + high) for v, (low, high) in zip(found.variables, found.domain, strict=True)}
        assert np.isfinite(float(found(**middle)))


def test_an_unknown_name_is_told():
    with pytest.raises(ecfit.EcfitError, match="unknown shipped fit 'conductor-9999'"):
        ecfit.shipped("conductor-9999")
    with pytest.raises(ecfit.EcfitError, match="unknown shipped fit"):
        ecfit.shipped("../published/kulla-conty-2017")


def test_what_lies_in_the_folder_is_shipped(tmp_path, monkeypatch: pytest.MonkeyPatch):
    home = __import__("sys").modules[module_function.__module__]
    monkeypatch.setattr(home, "shipped_folder", lambda: tmp_path)
    assert ecfit.shipped() == []
    data = ecfit.published("sforza-pellacini-2022-conductor").to_dict()
    write_json(tmp_path / "mine.json", data)
    assert ecfit.shipped() == ["mine"]
    np.testing.assert_array_equal(ecfit.shipped("mine").coefficients, data["coefficients"])
    (tmp_path / "broken.json").write_text("{}")
    with pytest.raises(ecfit.EcfitError, match="shipped fit 'broken': the key 'variables' is missing"):
        ecfit.shipped("broken")
