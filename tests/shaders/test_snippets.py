"""The snippet of docs/export.md for OSL: the closure has its arguments, and in Cycles a furnace is white."""

import importlib.util
import os
import re
import subprocess
from pathlib import Path

import pytest

from ecfit.approximation import shipped
from ecfit.export import code

HERE = Path(__file__).parent
SECTION = (HERE.parents[1] / "docs/export.md").read_text().partition("### OSL")[2].partition("###")[0]
SHADER = SECTION.partition("```c\n")[2].partition("```")[0]
CLOSURE = "generalized_schlick_bsdf"
BPY = os.environ.get("ECFIT_BPY_PYTHON")


def arguments(text):
    """Those of the first call of the closure: what no brackets of their own hold together."""
    inner = re.sub(r"\w+\([^()]*\)", "inner", text.partition(f" {CLOSURE}(")[2])
    return [part.strip() for part in inner.partition(")")[0].split(",")]


@pytest.mark.skipif(importlib.util.find_spec("MaterialX") is None, reason="no MaterialX")
def test_the_closure_has_the_arguments_that_materialx_gives_it():
    spec = importlib.util.find_spec("MaterialX")
    folder = Path(str(spec.origin)).parent / "libraries/pbrlib/genosl"
    theirs = arguments((folder / f"mx_{CLOSURE}.osl").read_text())
    theirs = theirs[: theirs.index("distribution") + 1]  # what follows are options by name
    ours = arguments(SHADER)
    assert len(ours) == len(theirs)
    assert [ours.index("N"), ours.index("F0")] == [theirs.index("N"), theirs.index("color0")]
    assert [i for i, a in enumerate(ours) if a == "alpha"] == [
        theirs.index("roughness.x"), theirs.index("roughness.y")
    ]  # fmt: skip
    assert [ours[theirs.index("exponent")], ours[-1]] == ["5", '"ggx"']


@pytest.mark.slow
@pytest.mark.skipif(not BPY, reason="no bpy: set ECFIT_BPY_PYTHON to a Python that has it")
def test_cycles_compiles_it_and_the_furnace_is_white(tmp_path):
    fit = shipped("conductor-correlated-10")
    white = SHADER.replace("color(1.0, 0.77, 0.34)", "color(1)").replace("alpha = 0.25", "alpha = 0.7")
    bare = white.replace("E_ggx_metal(abs(dot(N, I)), alpha, F0) * lobe", "lobe")
    assert len({SHADER, white, bare}) == 3
    found = []
    for name, text in [("compensated", white), ("bare", bare)]:
        path = tmp_path / f"{name}.osl"
        path.write_text(code(fit, "osl", name="E_ggx", factor=True, clamp=True) + text)
        command = [str(BPY), str(HERE / "cycles_furnace.py"), str(path), "60"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        told = re.search(r"^albedo (\S+)$", done.stdout, re.MULTILINE)
        assert told, done.stdout + done.stderr
        found.append(float(told[1]))
    print(f"white furnace in Cycles: {found[0]:.4f}, without the factor {found[1]:.4f}")
    assert found[0] == pytest.approx(1.0, abs=0.003)
    assert found[1] == pytest.approx(float(fit(mu=0.5, alpha=0.7)), abs=0.003)
