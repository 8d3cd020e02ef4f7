"""One sphere under one light, rendered by Mitsuba to NumPy arrays.

To be imported after `mitsuba.set_variant`.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ecfit.rendering import integrator as integrator  # registers the furnace's plugin
from ecfit.rendering._mitsuba import mitsuba
from ecfit.rendering.bsdf import Albedo, make
from ecfit.rendering.environment import studio
from ecfit.rendering.integrator import CHANNELS
from ecfit.rendering.sphere import AlbedoCode, Sphere

mi, dr = mitsuba()

# Half the width of a picture in radii of the sphere.
FRAME = 1.06
# Under the studio's light paths end by roulette from here on: unbiased, and most light has arrived.
_ROULETTE = 32


def bind(albedo: AlbedoCode) -> Albedo:
    """E as a function of mu on the variant's floats."""
    if albedo.text:
        names: dict[str, Any] = {}
        exec(albedo.text, names)  # what `ecfit.export` wrote in the process that started this one
        # Opaque: one compiled kernel for all roughnesses and indices.
        fixed = {name: dr.opaque(mi.Float, value) for name, value in albedo.fixed.items()}
        return lambda mu: names["E"](mu=mu, **fixed, xp=dr)
    nodes, values = np.array(albedo.nodes), np.array(albedo.values)
    slopes = np.diff(values) / np.diff(nodes)

    if not dr.is_jit_v(mi.Float):
        return lambda mu: float(np.interp(mu, nodes, values))
    x, y, s = mi.Float(nodes[:-1]), mi.Float(values[:-1]), mi.Float(slopes)

    def interpolated(mu: Any) -> Any:
        inner = mi.Float(nodes[1:-1])
        cell = dr.binary_search(0, len(nodes) - 2, lambda i: dr.gather(mi.Float, inner, i) <= mu)
        return dr.gather(mi.Float, y, cell) + (mu - dr.gather(mi.Float, x, cell)) * dr.gather(
            mi.Float, s, cell
        )

    return interpolated


def _scene(sphere: Sphere) -> Any:
    bsdf = make(sphere, {role: bind(albedo) for role, albedo in sphere.albedos.items()})
    transform = mi.ScalarTransform4f()
    view = transform.look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]) @ transform.scale([FRAME, FRAME, 1])
    constant = sphere.light == "constant"
    light: dict[str, Any] = {"type": "constant", "radiance": 1.0}
    walk: dict[str, Any] = {"type": "ecfit-furnace", "depth": sphere.depth, "candidates": sphere.candidates}
    if not constant:
        light = {"type": "envmap", "bitmap": mi.Bitmap(studio())}
        walk = {"type": "path", "max_depth": sphere.depth, "rr_depth": _ROULETTE, "hide_emitters": True}
    film = {
        "type": "hdrfilm",
        "width": sphere.pixels,
        "height": sphere.pixels,
        "rfilter": {"type": "box"},  # pixels that share no samples: their noise is independent
        "pixel_format": "luminance" if constant else "rgba",
    }
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": walk,
            "light": light,
            "sphere": {"type": "sphere", "bsdf": bsdf},
            "sensor": {
                "type": "orthographic",
                "to_world": view,
                "film": film,
                "sampler": {"type": "independent"},
            },
        }
    )


def render(sphere: Sphere) -> Mapping[str, np.ndarray]:
    """The picture of a sphere, and what it measures.

    Returns `picture` (height x width x 1, or 4 with coverage under the studio's light), means over all seeds.
    In the furnace also, for each pixel: `inside` (the part of it that is judged), and means over that part of
    `value` (light), `variance` (of value, from the scatter of the seeds), `mu` and `rest`.
    """
    scene, count = _scene(sphere), sphere.samples // sphere.seeds
    images = [
        np.array(mi.render(scene, spp=count, seed=seed), dtype=np.float64) for seed in range(sphere.seeds)
    ]
    if sphere.light != "constant":
        return {"picture": np.mean(images, axis=0).astype(np.float32)}
    stack = np.stack(images)[..., -len(CHANNELS) :]
    inside, light, mu, rest = np.moveaxis(stack, -1, 0)
    total = inside.sum(axis=0)
    safe = np.where(total > 0.0, total, 1.0)
    value = light.sum(axis=0) / safe
    # Of a ratio: pixels on the edge have other numbers of samples in every seed.
    scatter = ((light - inside * value) ** 2).sum(axis=0)
    variance = scatter / safe**2 * sphere.seeds / (sphere.seeds - 1)
    out = {
        "picture": np.mean(images, axis=0)[..., :1],
        "inside": total / sphere.seeds,
        "value": value,
        "variance": variance,
        "mu": mu.sum(axis=0) / safe,
        "rest": rest.sum(axis=0) / safe,
    }
    return {name: array.astype(np.float32) for name, array in out.items()}
