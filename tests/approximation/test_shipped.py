"""Shipped fits: each file loads, evaluates and says what it approximates; unknown names are told."""

import numpy as np
import pytest

import ecfit
from ecfit.approximation import shipped as module_function
from ecfit.approximation.shipped import shipped_folder
from ecfit.certify import Certificate
from ecfit.files import read_json, write_json


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


@pytest.mark.parametrize("name", ecfit.shipped())
def test_a_shipped_fit_was_certified_and_stays_within_0_and_1_in_single_precision(name: str):
    data = read_json(shipped_folder() / f"{name}.json")
    certificate = Certificate.from_dict(data["certificate"])
    assert certificate.certified
    assert certificate.name == name
    found = ecfit.shipped(name)
    rng = np.random.default_rng(3)
    # Towards the low ends too, where the corner is.
    points = [low + (high - low) * rng.random(4000) ** 4 for low, high in found.domain]
    single = found.formula.value([p.astype(np.float32) for p in points])
    assert single.dtype == np.float32
    assert np.all((single >= 0.0) & (single <= 1.0))
    double = found.formula.value([p.astype(np.float32).astype(np.float64) for p in points])
    assert np.abs(single - double).max() < 2e-6
