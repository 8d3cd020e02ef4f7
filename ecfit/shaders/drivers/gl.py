"""Runs a GLSL program over points on the first OpenGL device. A process of its own: drivers crash.

    python -P gl.py FOLDER compute|fragment

FOLDER holds `program` (text), `given.npy` (functions, points, 4) float32; written are `found.npy` (functions,
points) float32 and, as soon as there is one, `device.txt`. No ecfit here, so that it starts at once.
"""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

# By name: type checkers need not have the optional package.
moderngl: Any = import_module("moderngl")

# One triangle that covers the whole viewport.
_COVER = np.array([-1.0, -1.0, 3.0, -1.0, -1.0, 3.0], dtype=np.float32)
_VERTEX = "#version 300 es\nin vec2 at;\nvoid main() { gl_Position = vec4(at, 0.0, 1.0); }\n"


def compute(context: Any, program: str, given: np.ndarray) -> bytes:
    """One dispatch: a row of groups of 64 points a function."""
    functions, points, _ = given.shape
    inputs = context.buffer(given.tobytes())
    outputs = context.buffer(reserve=4 * functions * points)
    inputs.bind_to_storage_buffer(0)
    outputs.bind_to_storage_buffer(1)
    context.compute_shader(program).run(-(-points // 64), functions, 1)
    return outputs.read()


def fragment(context: Any, program: str, given: np.ndarray) -> bytes:
    """One triangle over a texture of float32: a row of texels a function."""
    functions, points, _ = given.shape
    size = (points, functions)
    inputs = context.texture(size, 4, given.tobytes(), dtype="f4")
    inputs.filter = (moderngl.NEAREST, moderngl.NEAREST)
    outputs = context.texture(size, 4, dtype="f4")
    context.framebuffer([outputs]).use()
    inputs.use(0)
    linked = context.program(vertex_shader=_VERTEX, fragment_shader=program)
    cover = context.vertex_array(linked, [(context.buffer(_COVER.tobytes()), "2f", "at")])
    cover.render(moderngl.TRIANGLES)
    return np.ascontiguousarray(np.frombuffer(outputs.read(), dtype=np.float32)[::4]).tobytes()


def main() -> None:
    folder, how = Path(sys.argv[1]), {"compute": compute, "fragment": fragment}[sys.argv[2]]
    given = np.load(folder / "given.npy")
    # Without a display; on Linux through EGL.
    options = {"backend": "egl"} if sys.platform.startswith("linux") else {}
    context = moderngl.create_context(standalone=True, require=430, **options)
    (folder / "device.txt").write_text(f"{context.info['GL_RENDERER']}, OpenGL {context.info['GL_VERSION']}")
    found = how(context, (folder / "program").read_text(), given)
    np.save(folder / "found.npy", np.frombuffer(found, dtype=np.float32).reshape(given.shape[:2]))


if __name__ == "__main__":
    main()
