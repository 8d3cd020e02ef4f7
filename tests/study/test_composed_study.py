"""A study puts composed forms together from its own fits, after them, and says what is missing."""

import pytest

import ecfit
from ecfit.errors import EcfitError
from ecfit.study.runner import load

CONFIG = """
name = "composed"
[[tables]]
name = "e"
model = "conductor"
axes = { r = { count = 5, low = 0.1, spacing = "gauss" }, mu = { count = 5, low = 0.1, spacing = "gauss" } }
tolerance = 1e-4
[[tables]]
name = "a"
model = "conductor"
quantity = "schlick-a"
axes = { r = { count = 5, low = 0.1, spacing = "gauss" }, mu = { count = 5, low = 0.1, spacing = "gauss" } }
tolerance = 1e-4
[[fits]]
tables = ["e"]
form = "structured"
name = "e-2"
head = "corner"
features = ["alpha", "mu"]
[fits.terms]
numerators = [[[1, 0], [0, 1]]]
denominator = [[3, 0], [0, 3]]
[[fits]]
tables = ["a"]
form = "composed"
name = "a-2"
text = "max(0.9*E, 0)"
parts = { E = "e-2" }
"""


@pytest.mark.usefixtures("no_report")
def test_a_composed_form_is_put_together_after_its_parts(tmp_path):
    path = tmp_path / "composed.toml"
    path.write_text(CONFIG)
    study = ecfit.run(path, tmp_path / "results", workers=1)
    (part,), (whole,) = study.fits["e"], study.fits["a"]
    assert whole.status == part.status == "converged"
    assert whole.approximation.form == "composed"
    assert whole.approximation.contract.quantity == "schlick-a"
    assert float(whole(mu=0.5, r=0.6)) == pytest.approx(0.9 * float(part(mu=0.5, r=0.6)))
    assert whole.approximation.domain == ((0.0, 1.0), (0.0, 1.0))
    again = load(path, tmp_path / "results").fits["a"][0]
    assert again.to_dict() == whole.to_dict()
    # Other coefficients of a part are another whole.
    path.write_text(CONFIG.replace("[0, 3]]", "[0, 3], [1, 2]]"))
    changed = ecfit.run(path, tmp_path / "results", workers=1).fits["a"][0]
    assert changed.to_dict() != whole.to_dict()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('E = "e-2"', 'E = "e-3"', "fit 'a-2': unknown fit named before it 'e-3': expected one of e-2"),
        ('name = "a-2"\n', "", "a composed form needs a name"),
        ('parts = { E = "e-2" }', 'parts = { E = "e-2" }\nnorm = "l4"', "norm does not belong to the form"),
        ('text = "max(0.9*E, 0)"', 'text = "F"', "unknown name 'F'"),
    ],
)
def test_nonsense_is_told_before_anything_is_computed(tmp_path, old, new, words):
    path = tmp_path / "composed.toml"
    path.write_text(CONFIG.replace(old, new))
    with pytest.raises(EcfitError, match=words):
        ecfit.run(path, tmp_path / "results")
    assert not (tmp_path / "results/tables").exists()
