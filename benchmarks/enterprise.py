"""The figures and numbers of docs/systems/enterprise-pbr.md that are no fits: furnaces, anisotropy, readings.

    python benchmarks/enterprise.py [--only furnace] [--figures docs/figures]

Prints Markdown tables. Minutes on one core, most of it compilation.
"""

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import equinox as eqx
import numpy as np
from matplotlib.figure import Figure

import ecfit
from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.coordinates import Axis
from ecfit.enterprise import isotropic_equivalent
from ecfit.quantities import DirectionalAlbedo
from ecfit.report.style import look, rendered

MU = np.cos(np.linspace(0.0, np.arccos(0.02), 24))[::-1].copy()
LEVEL = 1
NAMES = {"none": "no compensation", "printed": "printed fits", "tables": "tables", "exact": "integrals"}


@eqx.filter_jit
def _albedo(model: BSDF, name: str, values: jax.Array, mu: jax.Array) -> jax.Array:
    quantity = DirectionalAlbedo("all", "energy")

    def one(value: jax.Array, m: jax.Array) -> jax.Array:
        return quantity.estimate(model.with_parameters({name: value}), m, LEVEL).value

    return jax.lax.map(lambda v: jax.lax.map(lambda m: one(v, m), mu), values)


def albedos(model: BSDF, name: str, values: Sequence[float], mu: np.ndarray = MU) -> np.ndarray:
    """R + T in energy transport over (values of a parameter, MU)."""
    return np.asarray(_albedo(model, name, jnp.asarray(values), jnp.asarray(mu)))


def _row(label: str, found: np.ndarray) -> str:
    """Average over the hemisphere, least and largest with their cosines."""
    average = np.trapezoid(2.0 * MU * found, MU) / np.trapezoid(2.0 * MU, MU)
    low, high = int(np.argmin(found)), int(np.argmax(found))
    ends = f"{found[low]:.4f} ({MU[low]:.2f}) | {found[high]:.4f} ({MU[high]:.2f})"
    return f"| {label} | {average:.4f} | {ends} |"


def _show(title: str, rows: Iterable[tuple[str, np.ndarray]]) -> None:
    """A table of albedos over MU, a line each, printed as they come."""
    print(f"\n| {title} | average | least (mu) | largest (mu) |\n|---|---:|---:|---:|")
    for label, found in rows:
        print(_row(label, found), flush=True)


def _over(
    model: BSDF, name: str, values: Mapping[str, float], after: str = ""
) -> Iterator[tuple[str, np.ndarray]]:
    """(label, albedos over MU) of each value of a parameter."""
    labels = (f"{label}{after}" for label in values)
    yield from zip(labels, albedos(model, name, list(values.values())), strict=True)


# Labels of the document's roughnesses r, and their GGX widths.
ROUGHNESS = {f"r = {r}": r * r for r in (0.1, 0.6, 0.9)}


def furnace_metallic(figures: Path | None) -> None:
    """The document's furnace: r = 0.1, 0.6, 0.9 and F0 = F90 = 1."""
    rows = [
        row
        for energy, label in NAMES.items()
        for row in _over(
            ecfit.model("enterprise-metallic", energy=energy, F0=1.0), "alpha", ROUGHNESS, f", {label}"
        )
    ]
    _show("metallic, F0 = 1", rows)
    if figures is not None:
        _draw(figures / "enterprise-metallic-furnace.svg", rows, list(NAMES.values()), list(ROUGHNESS))


def readings(figures: Path | None) -> None:
    """The metallic furnace at F0 = 1 with the printed fits of other readings of alpha_uv."""
    fit, average = (ecfit.published("enterprise-pbr-2019x" + part) for part in ("", "-average"))
    x, w = np.polynomial.legendre.leggauss(24)
    nodes = 0.5 * (x + 1.0)
    isotropic = ecfit.model("conductor", masking="height-correlated")

    def furnace(alpha: float, read: float) -> np.ndarray:
        truth = np.asarray(ecfit.directional_albedo(isotropic, alpha=alpha, mu=MU))
        mean = float(w @ (nodes * np.asarray(fit(alpha=read, mu=nodes))))
        lost = (1.0 - np.asarray(fit(alpha=read, mu=MU))) * (1.0 - mean)
        return truth + lost / (1.0 - float(average(alpha=read)))

    read_as = {"alpha": 1.0, "r": 0.5, "alpha^2": 2.0}
    _show(
        "metallic, F0 = 1, printed fits",
        (
            (f"{r}, alpha_uv = {label}", furnace(alpha, alpha**power))
            for r, alpha in ROUGHNESS.items()
            for label, power in read_as.items()
        ),
    )


def furnace_opaque(figures: Path | None) -> None:
    """The document's furnace of the base: r = 0.5 and F0 = 0.04, 0.5, 0.9."""
    ior = {f"F0 = {x}": (1.0 + x**0.5) / (1.0 - x**0.5) for x in (0.04, 0.5, 0.9)}
    names = {energy: label for energy, label in NAMES.items() if energy != "none"}
    rows = [
        row
        for energy, label in names.items()
        for row in _over(
            ecfit.model("enterprise-opaque", energy=energy, alpha=0.25), "ior", ior, f", {label}"
        )
    ]
    _show("opaque, rho = 1, r = 0.5", rows)
    if figures is not None:
        _draw(figures / "enterprise-opaque-furnace.svg", rows, list(names.values()), list(ior))


def furnace_sheen(figures: Path | None) -> None:
    """The base's sheen: b = 0, 0.3, 0.6, 1 over white, and the lobe M_b alone."""
    widths = {f"b = {b}": b for b in (0.0, 0.1, 0.3, 0.6, 1.0)}
    over_white = ecfit.model("enterprise-opaque", energy="printed", alpha=0.25)
    _show("opaque with sheen, rho = 1, r = 0.5, printed fits", _over(over_white, "b", widths))
    _show("M_b alone", _over(ecfit.model("ashikhmin-sheen"), "b", widths))


def furnace_core(figures: Path | None) -> None:
    """Transparent and mixed cores with exact albedos: what the model itself loses."""
    cases = {
        "thin, transparent": {"t": 1.0},
        "volumetric, transparent, from outside": {"t": 1.0, "kind": "volumetric"},
        "volumetric, transparent, from inside": {"t": 1.0, "kind": "volumetric", "side": "leaving"},
        "m = 0.5, t = 0.5, merged": {"m": 0.5, "t": 0.5},
        "m = 0.5, t = 0.5, sum": {"m": 0.5, "t": 0.5, "blend": "sum"},
        "opaque, s = 0.5, merged": {"s": 0.5},
        "opaque, s = 0.5, sum": {"s": 0.5, "blend": "sum"},
        "opaque, printed fits": {"energy": "printed"},
        "opaque, printed fits, clear coat of r = 0.3": {"coat": "clear", "energy": "printed"},
    }
    _show(
        "core, rho = 1, ior = 1.5",
        (
            (f"{label}, {r}", found)
            for label, settings in cases.items()
            for r, found in _over(ecfit.model("enterprise-pbr", **settings), "alpha", ROUGHNESS)
        ),
    )


def anisotropy(figures: Path | None) -> None:
    """E_m of anisotropic GGX against isotropic stand-ins, by the strength o = 1 - r_v / r_u."""
    strengths = [0.1, 0.3, 0.5, 0.8]
    axes = {
        "r": Axis.spaced("r", 7, 0.1, 1.0, "gauss"),
        "aspect": Axis.given("aspect", sorted((1.0 - o) ** 2 for o in strengths)),
        "phi": Axis.spaced("phi", 6, 0.0, 0.5 * np.pi, "gauss"),
        "mu": Axis.spaced("mu", 7, 0.02, 1.0, "gauss"),
    }
    table = ecfit.tabulate("anisotropic-conductor", axes, tolerance=1e-4)
    r, aspect, phi, mu = np.meshgrid(*(a.nodes for a in table.axes), indexing="ij")
    u, v = r**2, r**2 * aspect
    weights = np.polynomial.legendre.leggauss(6)[1] / 2.0
    isotropic = ecfit.model("conductor", masking="height-correlated")

    def of(alpha: np.ndarray, cosine: np.ndarray = mu) -> np.ndarray:
        return np.asarray(ecfit.directional_albedo(isotropic, alpha=alpha, mu=cosine))

    rows = {
        "alpha_u alpha_v (as printed)": of(u * v),
        "sqrt(alpha_u alpha_v)": of(np.sqrt(u * v)),
        "(alpha_u + alpha_v) / 2": of(0.5 * (u + v)),
        "root mean square": of(np.sqrt(0.5 * (u * u + v * v))),
        "width seen by wo": of(np.sqrt((u * np.cos(phi)) ** 2 + (v * np.sin(phi)) ** 2)),
        "root mean square, masking of wo kept": of(*map(np.asarray, isotropic_equivalent(u, v, phi, mu))),
    }
    print(f"\nlargest error estimate of the integrals: {table.errors.max():.1e}")
    print("\n| substitution, by azimuth | " + " | ".join(f"o = {o}" for o in strengths) + " |")
    print("|---" * (1 + len(strengths)) + "|")
    order = [int(np.argmin(np.abs(table.axes[1].nodes - (1.0 - o) ** 2))) for o in strengths]
    for label, found in rows.items():
        error = np.abs(found - table.values)
        print(f"| {label} | " + " | ".join(_cell(error[:, i]) for i in order) + " |")
    print("\n| substitution, mean over azimuths | " + " | ".join(f"o = {o}" for o in strengths) + " |")
    print("|---" * (1 + len(strengths)) + "|")
    for label, found in rows.items():
        error = np.abs(np.einsum("rapm,p->ram", found - table.values, weights))
        print(f"| {label} | " + " | ".join(_cell(error[:, i]) for i in order) + " |")


def _cell(error: np.ndarray) -> str:
    return f"{error.mean():.1e} / {error.max():.1e}"


def _draw(
    path: Path, rows: Sequence[tuple[str, np.ndarray]], labels: Sequence[str], titles: Sequence[str]
) -> None:
    """Albedo against mu, a panel a setting, a line a source; rows are by source, then by setting."""
    colours = ("#999999", "#D55E00", "#0072B2", "#000000")[-len(labels) :]
    with look():
        figure = Figure(figsize=(7.6, 2.5), layout="constrained")
        panels = np.atleast_1d(figure.subplots(1, len(titles), sharey=True))
        for i, (panel, title) in enumerate(zip(panels, titles, strict=True)):
            for (_, found), label, colour in zip(rows[i :: len(titles)], labels, colours, strict=True):
                panel.plot(MU, found, color=colour, label=label, lw=1.2)
            panel.set_title(title)
            panel.set_xlabel("mu")
        panels[0].set_ylabel("white furnace: R + T")
        panels[-1].legend(frameon=False, fontsize=7)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(rendered(figure, path.suffix[1:]))


SECTIONS: dict[str, Callable[[Path | None], None]] = {
    "metallic": furnace_metallic,
    "readings": readings,
    "opaque": furnace_opaque,
    "sheen": furnace_sheen,
    "core": furnace_core,
    "anisotropy": anisotropy,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=list(SECTIONS), help="one section")
    parser.add_argument("--figures", type=Path, help="folder of the figures")
    given = parser.parse_args()
    for name, section in SECTIONS.items():
        if given.only in (None, name):
            section(given.figures)


if __name__ == "__main__":
    main()
