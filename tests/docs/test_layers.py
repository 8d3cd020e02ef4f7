"""The picture of the layers is that of the imports, and the imports go one way."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DRAWING = runpy.run_path(str(ROOT / "docs" / "site" / "layers.py"))
ORDER, IMPORTS = DRAWING["layers"](), DRAWING["imports"]()

# `fit.to_code("glsl")` hands the fit to the layer that writes code, when it is called.
CONVENIENCES = {("approximation", "export"), ("fitting", "export")}


def test_every_package_has_its_place():
    assert sorted(ORDER) == sorted(DRAWING["packages"]())


@pytest.mark.parametrize("name", ORDER)
def test_a_package_imports_only_from_those_above_it(name: str):
    below = ORDER[ORDER.index(name) + 1 :]
    up = {(name, other): late for other, late in IMPORTS[name].items() if other in below}
    assert set(up) <= CONVENIENCES
    assert all(up.values())


def test_the_picture_is_drawn_from_the_imports():
    drawn = DRAWING["picture"](ORDER, IMPORTS)
    assert DRAWING["PICTURE"].read_text() == drawn, "run: python docs/site/layers.py"
    assert drawn.count("<circle") == sum(map(len, IMPORTS.values()))
