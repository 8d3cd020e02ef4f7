"""Runs an OSL shader over points in Blender's Cycles on the processor, as the emission of a plane.

    PYTHON -P cycles.py FOLDER        # PYTHON has bpy

FOLDER holds `program` (OSL text) and `given.npy` (functions, points, 4) float32; written are `found.npy`
(functions, points) float32 and `device.txt`. A pixel is a point; only its red is used.
"""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

# Blender has no smaller pictures.
_LEAST = 4

bpy: Any = import_module("bpy")


def source(program: str, given: np.ndarray) -> str:
    """The shader with the points as numbers that are read back as they are."""
    numbers = ", ".join(np.format_float_scientific(x, unique=True, trim="0") for x in given.ravel())
    return program.replace("@numbers@", str(given.size)).replace("@given@", numbers)


def scene(shader: Path, width: int, height: int) -> None:
    """A plane over the pixels' own coordinates, seen straight from above, which emits the shader's output."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    here = bpy.context.scene
    here.render.engine = "CYCLES"
    here.cycles.device = "CPU"
    here.cycles.shading_system = True
    # One ray a pixel, and nothing that mixes neighbours.
    here.cycles.samples, here.cycles.use_denoising = 1, False
    here.cycles.pixel_filter_type, here.cycles.max_bounces = "BOX", 0
    here.render.resolution_x, here.render.resolution_y = width, height
    here.render.resolution_percentage = 100
    here.render.threads_mode, here.render.threads = "FIXED", 1

    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(0, 0, 0), (width, 0, 0), (width, height, 0), (0, height, 0)], [], [(0, 1, 2, 3)])
    plane = bpy.data.objects.new("plane", mesh)
    here.collection.objects.link(plane)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(width, height)
    camera.clip_end = 10.0
    eye = bpy.data.objects.new("camera", camera)
    eye.location = (0.5 * width, 0.5 * height, 1.0)
    here.collection.objects.link(eye)
    here.camera = eye

    material = bpy.data.materials.new("probe")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    script = nodes.new("ShaderNodeScript")
    script.mode, script.filepath = "EXTERNAL", str(shader)
    script.outputs.new("NodeSocketColor", "found")
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    links.new(script.outputs["found"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    mesh.materials.append(material)


def rendered(path: Path, width: int, height: int) -> np.ndarray:
    """Red of each pixel, float32, the first row at the bottom."""
    image_settings = bpy.context.scene.render.image_settings
    image_settings.file_format, image_settings.color_depth = "OPEN_EXR", "32"
    image_settings.color_mode = "RGB"
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(image.channels * width * height, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return pixels[:: image.channels].reshape(height, width)


def main() -> None:
    folder = Path(sys.argv[1])
    (folder / "device.txt").write_text(f"Cycles of Blender {bpy.app.version_string}")
    given = np.load(folder / "given.npy")
    functions, points, _ = given.shape
    width, height = max(points, _LEAST), max(functions, _LEAST)
    shader, compiled = folder / "probe.osl", folder / "probe.oso"
    shader.write_text(source((folder / "program").read_text(), given))
    if not import_module("_cycles").osl_compile(str(shader), str(compiled)):
        raise SystemExit("Blender's OSL compiler refuses the shader")
    scene(compiled, width, height)
    found = rendered(folder / "found.exr", width, height)
    np.save(folder / "found.npy", found[:functions, :points])


if __name__ == "__main__":
    main()
