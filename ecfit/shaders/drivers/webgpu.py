"""Runs a compute shader over points on the first device of wgpu. A process of its own: drivers crash.

    python -P webgpu.py FOLDER

FOLDER holds `program` (WGSL as text or SPIR-V), `given.npy` (functions, points, 4) float32; written are
`found.npy` (functions, points) float32 and, as soon as there is one, `device.txt`. No ecfit here, so that it
starts at once.
"""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

# By name: type checkers need not have the optional package.
wgpu: Any = import_module("wgpu")

# The first word of SPIR-V (Khronos SPIR-V specification, 2.3), as it is stored on the machines here.
_SPIRV = b"\x03\x02\x23\x07"


def run(device: Any, program: str | bytes, given: np.ndarray) -> np.ndarray:
    """Values (functions, points)."""
    functions, points, _ = given.shape
    storage, copied = wgpu.BufferUsage.STORAGE, wgpu.BufferUsage.COPY_SRC
    inputs = device.create_buffer_with_data(data=given.tobytes(), usage=storage)
    outputs = device.create_buffer(size=4 * functions * points, usage=storage | copied)
    module = device.create_shader_module(code=program)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": module, "entry_point": "main"}
    )
    bound = [
        {"binding": i, "resource": {"buffer": b, "offset": 0, "size": b.size}}
        for i, b in enumerate((inputs, outputs))
    ]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=bound)
    encoder = device.create_command_encoder()
    one = encoder.begin_compute_pass()
    one.set_pipeline(pipeline)
    one.set_bind_group(0, group)
    one.dispatch_workgroups(-(-points // 64), functions, 1)
    one.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(outputs), dtype=np.float32).reshape(functions, points)


def main() -> None:
    folder = Path(sys.argv[1])
    adapter = wgpu.gpu.request_adapter_sync()
    device = adapter.request_device_sync()
    (folder / "device.txt").write_text(f"{adapter.info['device']}, {adapter.info['backend_type']}")
    text = (folder / "program").read_bytes()
    program = text if text.startswith(_SPIRV) else text.decode()
    np.save(folder / "found.npy", run(device, program, np.load(folder / "given.npy")))


if __name__ == "__main__":
    main()
