"""Run in a process of its own: `python bsdf_checks.py VARIANT` prints what each BSDF does, as JSON lines.

For each material and direction of the camera: the integrals of f cos and of the density over the sphere, what
samples say about both, and chi-square between samples and density.
"""

# ruff: noqa: E402 (Mitsuba's variant is set before its classes are derived from)

import json
import sys

import mitsuba as mi
import numpy as np

mi.set_variant(sys.argv[1])

from ecfit.rendering.bsdf import make
from ecfit.rendering.scene import bind
from ecfit.rendering.sphere import AlbedoCode, Sphere

# Any functions of mu between 0 and 1 will do: the tests divide by the same.
FIXED = AlbedoCode("line", nodes=(0.0, 0.25, 1.0), values=(0.5, 0.7, 0.9))
CASES = [
    ("conductor", None, {"conductor": FIXED}),
    ("glossy", 1.5, {"conductor": FIXED, "glossy": FIXED}),
    ("glossy", 1.5, {}),
    ("thin-dielectric", 1.5, {"conductor": FIXED}),
    ("dielectric", 1.5, {"entering": FIXED, "leaving": FIXED}),
]
ALPHA_ROOT = 0.7
# Directions: z by Gauss-Legendre on both hemispheres, the azimuth by its mirror image at equal steps.
NODES, AZIMUTHS, SAMPLES = 200, 256, 100_000
BINS = (8, 8)


def interaction(z: float, count: int):
    si = mi.SurfaceInteraction3f()
    si.t = mi.Float(1.0)
    si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    si.n = mi.Normal3f(0, 0, 1)
    si.wi = mi.Vector3f(mi.Float(np.full(count, (1 - z * z) ** 0.5)), 0.0, z)
    return si


def check(model: str, ior, albedos, z: float) -> dict:
    sphere = Sphere(
        "m",
        "row",
        model,
        "constant",
        ALPHA_ROOT,
        ior,
        None,
        None,
        (1.0, 1.0, 1.0),
        albedos,
        (),
        8,
        8,
        8,
        8,
        8,
    )
    bsdf = make(sphere, {role: bind(a) for role, a in albedos.items()})
    context = mi.BSDFContext()
    x, w = np.polynomial.legendre.leggauss(NODES)
    # Squared towards the horizon, where shadowing has a root.
    up, weight = (0.5 * (x + 1)) ** 2, 0.5 * w * (x + 1)
    cos, weight = np.r_[-up[::-1], up], np.r_[weight[::-1], weight]
    phi = 2 * np.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    c, p = (a.ravel() for a in np.meshgrid(cos, phi, indexing="ij"))
    s = np.sqrt(1 - c * c)
    wo = mi.Vector3f(mi.Float(s * np.cos(p)), mi.Float(s * np.sin(p)), mi.Float(c))
    value, density = bsdf.eval_pdf(context, interaction(z, c.size), wo)
    area = np.repeat(weight, AZIMUTHS) * 2 * np.pi / AZIMUTHS
    density = np.array(density, dtype=float) * area
    rng = np.random.default_rng(3)
    u = rng.random((3, SAMPLES), dtype=np.float32)
    out, factor = bsdf.sample(
        context, interaction(z, SAMPLES), mi.Float(u[0]), mi.Point2f(mi.Float(u[1]), mi.Float(u[2]))
    )
    d = np.array(out.wo, dtype=float)
    weights = np.array(factor[0], dtype=float)
    valid = (np.array(out.pdf, dtype=float) > 0) & (weights > 0)
    sizes = np.linspace(-1, 1, BINS[0] + 1), np.linspace(-np.pi, np.pi, BINS[1] + 1)
    angle = np.arctan2(np.sin(p), np.cos(p))
    expected = SAMPLES * np.histogram2d(c, angle, sizes, weights=density)[0]
    counted = np.histogram2d(d[2][valid], np.arctan2(d[1], d[0])[valid], sizes)[0]
    known = expected > 20
    seen = bsdf.eval(context, interaction(z, SAMPLES), out.wo)
    ratio = np.array(seen[0], dtype=float)[valid] / np.array(out.pdf, dtype=float)[valid] / weights[valid]
    return {
        "model": model,
        "compensated": bool(albedos),
        "z": z,
        "eval": float(np.array(value[0], dtype=float) @ area),
        "sampled": float(np.mean(weights * valid)),
        "scatter": float(np.std(weights * valid) / SAMPLES**0.5),
        "pdf": float(density.sum()),
        "valid": float(valid.mean()),
        # The rule's bins have kinks of refraction within: 2 % is allowed for it beside the scatter.
        "chi2": float(np.sum(((counted - expected) ** 2 / (expected + (0.02 * expected) ** 2))[known])),
        "bins": int(known.sum()),
        # f cos / pdf against the weight that sampling returns.
        "ratio": float(np.quantile(np.abs(ratio - 1), 0.999)),
    }


for model, ior, albedos in CASES:
    for z in (0.35, 0.9) + ((-0.35, -0.9) if "dielectric" in model else ()):
        print(json.dumps(check(model, ior, albedos, z)))
