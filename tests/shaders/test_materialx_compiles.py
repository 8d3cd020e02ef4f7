"""Whole shaders that MaterialX generates from exported nodes compile: GLSL, ESSL, and OSL in Blender."""

import os
import subprocess
from importlib import import_module

import pytest

from ecfit.approximation import shipped
from ecfit.export import Options, materialx
from ecfit.shaders.compilers import GLSLANG, Step

mx = pytest.importorskip("MaterialX", reason="no MaterialX: pip install 'ecfit[shaders]'")

# Generator -> (module, class, how its pixel shader is judged).
GENERATORS = {
    "glsl": ("PyMaterialXGenGlsl", "GlslShaderGenerator"),
    "essl": ("PyMaterialXGenGlsl", "EsslShaderGenerator"),
    "osl": ("PyMaterialXGenOsl", "OslShaderGenerator"),
}


def generated(folder, generator):
    """The pixel shader of a graph: a metal's factor times the albedo of a dielectric, from two libraries."""
    standard, document = mx.createDocument(), mx.createDocument()
    path = mx.getDefaultDataSearchPath()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), path, standard)
    for name, options in (
        ("conductor-10", Options(name="metal_E", factor=True, coordinates=("r",))),
        ("dielectric-entering-20", Options(name="glass_E", coordinates=("ior",), clamp=True)),
    ):
        for file, text in materialx(shipped(name), options).items():
            (folder / file).write_text(text)
        mx.readFromXmlFile(standard, str(folder / f"{options.name}.mtlx"))
    document.setDataLibrary(standard)
    graph = document.addNodeGraph("graph")
    metal = graph.addNode("metal_E_metal", "metal", "color3")
    metal.setInputValue("mu", 0.3, "float")
    glass = graph.addNode("glass_E", "glass", "float")
    glass.setInputValue("ior", 1.5, "float")
    product = graph.addNode("multiply", "product", "color3")
    product.addInput("in1", "color3").setConnectedNode(metal)
    product.addInput("in2", "float").setConnectedNode(glass)
    output = graph.addOutput("out", "color3")
    output.setConnectedNode(product)
    valid, why = document.validate()
    assert valid, why
    module, name = GENERATORS[generator]
    shading = import_module("MaterialX.PyMaterialXGenShader")
    # The context's own generator has lost its type, and generates nothing.
    maker = getattr(import_module(f"MaterialX.{module}"), name).create()
    context = shading.GenContext(maker)
    context.registerSourceCodeSearchPath(path)
    context.registerSourceCodeSearchPath(mx.FileSearchPath(str(folder)))
    shader = maker.generate("shader", output, context)
    source = shader.getSourceCode("pixel")
    assert "mx_metal_E_metal(" in source
    assert "mx_glass_E(" in source
    return source


@pytest.mark.skipif(GLSLANG.missing() is not None, reason=str(GLSLANG.missing()))
@pytest.mark.parametrize("generator", ["glsl", "essl"])
def test_generated_glsl_compiles(tmp_path, generator):
    source = generated(tmp_path, generator)
    judge = Step(GLSLANG, ("-S", "frag", "{source}"), "generated.frag")
    assert judge.run(source.encode(), tmp_path) == source.encode()


@pytest.mark.slow
@pytest.mark.skipif(
    not os.environ.get("ECFIT_BPY_PYTHON"), reason="set ECFIT_BPY_PYTHON to a Python with bpy"
)
def test_generated_osl_compiles_in_blender(tmp_path):
    (tmp_path / "shader.osl").write_text(generated(tmp_path, "osl"))
    compiled = f"_cycles.osl_compile(sys.argv[1], {str(tmp_path / 'shader.oso')!r})"
    program = f"import sys, bpy, _cycles; sys.exit(not {compiled})"
    command = [os.environ["ECFIT_BPY_PYTHON"], "-c", program, str(tmp_path / "shader.osl")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
