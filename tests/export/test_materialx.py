"""A MaterialX library: valid, found by the generators, its coefficients to the last digit in their output."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from ecfit.approximation import shipped
from ecfit.errors import EcfitError
from ecfit.export import Options, materialx, write

FAMILY = {"glsl": "Glsl", "essl": "Glsl", "osl": "Osl", "msl": "Msl"}
OPTIONS = Options(name="ecfit_E", coordinates=("r",), factor=True, clamp=True)


def test_nodes_and_implementations_belong_together():
    files = materialx(shipped("conductor-10"), OPTIONS)
    assert sorted(files) == ["ecfit_E.glsl", "ecfit_E.metal", "ecfit_E.mtlx", "ecfit_E.osl"]
    root = ElementTree.fromstring(files["ecfit_E.mtlx"])
    defined = {n.get("name"): n for n in root.iter("nodedef")}
    assert sorted(defined) == ["ND_ecfit_E", "ND_ecfit_E_factor", "ND_ecfit_E_metal"]
    implemented = list(root.iter("implementation"))
    assert len(implemented) == 9
    for one in implemented:
        inputs = [i.get("name") for i in defined[one.get("nodedef")].iter("input")]
        source = files[one.get("file") or ""]
        head = re.search(rf"void {one.get('function')}\((.*)\)", source)
        assert head is not None
        assert [a.split()[-1] for a in head[1].split(", ")] == [*inputs, "result"]
    assert 'type="color3"' in files["ecfit_E.mtlx"]
    assert "0.516553" not in files["ecfit_E.mtlx"]


def test_a_library_is_a_folder(tmp_path):
    told = write(shipped("conductor-7"), "materialx", Options(), tmp_path / "library")
    assert len(told.splitlines()) == 4
    assert (tmp_path / "library" / "conductor_7.osl").read_text().count("void mx_conductor_7(") == 1
    with pytest.raises(EcfitError, match="say --output FOLDER"):
        write(shipped("conductor-7"), "materialx", Options(), None)


@pytest.mark.parametrize("generator", ["glsl", "essl", "osl", "msl"])
def test_the_generators_take_it(tmp_path, generator):
    mx = pytest.importorskip("MaterialX", reason="MaterialX is not installed")
    from importlib import import_module

    for name, text in materialx(shipped("conductor-10"), OPTIONS).items():
        (tmp_path / name).write_text(text)
    module = import_module(f"MaterialX.PyMaterialXGen{FAMILY[generator]}")
    render = import_module("MaterialX.PyMaterialXGenShader")
    standard, document = mx.createDocument(), mx.createDocument()
    path = mx.getDefaultDataSearchPath()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), path, standard)
    mx.readFromXmlFile(standard, str(tmp_path / "ecfit_E.mtlx"))
    document.setDataLibrary(standard)
    graph = document.addNodeGraph("graph")
    node = graph.addNode("ecfit_E_metal", "metal", "color3")
    node.setInputValue("mu", 0.3, "float")
    output = graph.addOutput("out", "color3")
    output.setConnectedNode(node)
    assert document.validate()[0]
    made = f"{generator.title()}ShaderGenerator"
    maker = getattr(module, made).create()
    context = render.GenContext(maker)
    context.registerSourceCodeSearchPath(path)
    context.registerSourceCodeSearchPath(mx.FileSearchPath(str(tmp_path)))
    maker.registerTypeDefs(document)
    shader = maker.generate("shader", output, context)
    source = shader.getSourceCode("pixel")
    assert "mx_ecfit_E_metal(" in source
    numbers = {np.float32(n) for n in re.findall(r"\d+\.\d+(?:e-\d+)?", source)}
    assert {np.float32(abs(c)) for c in shipped("conductor-10").coefficients} <= numbers
