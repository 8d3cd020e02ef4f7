"""The directional albedo of an OSL shader in Blender's Cycles: a plane under a white sky.

    PYTHON cycles_furnace.py SHADER DEGREES        # PYTHON has bpy

SHADER is OSL text whose output `result` is a closure; printed is `albedo`, the mean of all pixels, seen at
DEGREES from the normal.
"""

import math
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

bpy: Any = import_module("bpy")
_WIDTH = 4  # Blender has no smaller pictures


def scene(shader: Path, angle: float) -> None:
    """A large plane, lit by the sky alone, seen at an angle from its normal."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    here = bpy.context.scene
    here.render.engine = "CYCLES"
    here.cycles.device, here.cycles.shading_system = "CPU", True
    here.cycles.samples, here.cycles.use_adaptive_sampling = 4096, False
    here.cycles.use_denoising, here.cycles.max_bounces = False, 1
    here.render.resolution_x = here.render.resolution_y = _WIDTH
    here.render.threads_mode, here.render.threads = "FIXED", 1

    here.world = bpy.data.worlds.new("sky")
    here.world.use_nodes = True
    here.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    here.collection.objects.link(bpy.data.objects.new("plane", mesh))
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 1.0
    here.camera = bpy.data.objects.new("camera", camera)
    here.camera.location = (0.0, -5.0 * math.sin(angle), 5.0 * math.cos(angle))
    here.camera.rotation_euler = (angle, 0.0, 0.0)
    here.collection.objects.link(here.camera)

    material = bpy.data.materials.new("shader")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    script = nodes.new("ShaderNodeScript")
    script.mode, script.filepath = "EXTERNAL", str(shader)
    script.outputs.new("NodeSocketShader", "result")
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(script.outputs["result"], output.inputs["Surface"])
    mesh.materials.append(material)


def main() -> None:
    shader, degrees = Path(sys.argv[1]), float(sys.argv[2])
    compiled, picture = shader.with_suffix(".oso"), shader.with_suffix(".exr")
    if not import_module("_cycles").osl_compile(str(shader), str(compiled)):
        raise SystemExit("Blender's OSL compiler refuses the shader")
    scene(compiled, math.radians(degrees))
    here = bpy.context.scene.render
    here.image_settings.file_format, here.image_settings.color_depth = "OPEN_EXR", "32"
    here.filepath = str(picture)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(picture))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(image.channels * _WIDTH**2, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    print("albedo", pixels[:: image.channels].mean())


if __name__ == "__main__":
    main()
