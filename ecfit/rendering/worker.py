"""The process that renders: `python -m ecfit.rendering.worker VARIANT SPHERES FOLDER`.

Apart from the rest, and without JAX: a wrong LLVM ends the process, and Mitsuba's classes belong to one
variant. SPHERES is a JSON list of spheres; each picture is a file of FOLDER named after the sphere's key, and
what is finished is told by a line of its number.
"""

import io
import json
import sys
import time
from pathlib import Path

import numpy as np

from ecfit.files import write_atomically
from ecfit.rendering._mitsuba import mitsuba
from ecfit.rendering.sphere import Sphere


def main(variant: str, spheres: str, folder: str) -> None:
    """Render all spheres of a file."""
    mi, _ = mitsuba()
    mi.set_variant(variant)
    # Python integrators are slow in scalar variants; `ecfit.rendering.variant` has said so.
    mi.set_log_level(mi.LogLevel.Error)
    from ecfit.rendering.scene import render

    for number, data in enumerate(json.loads(Path(spheres).read_text(encoding="utf-8"))):
        sphere = Sphere.from_dict(data)
        start = time.perf_counter()
        arrays = dict(render(sphere))
        arrays["seconds"] = np.array(time.perf_counter() - start)
        buffer = io.BytesIO()
        np.savez_compressed(buffer, allow_pickle=False, **arrays)
        path = Path(folder) / f"{sphere.key(variant)}.npz"
        write_atomically(path, lambda file, data=buffer: file.write(data.getvalue()))
        print(number, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
