"""The furnace of a config without a renderer: one scattering of each material, integrated over all light.

A sphere of metal or plastic scatters light once, so that its picture and these numbers must agree. Light
inside glass is scattered many times, and what each scattering adds or loses adds up: here both sides of its
surface stand alone.
"""

import csv
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecfit._jax import jnp
from ecfit.approximation import Approximation
from ecfit.bsdf import model
from ecfit.config.furnace import NEEDS, FurnaceConfig, MaterialConfig, RowConfig, read_furnace
from ecfit.errors import EcfitError
from ecfit.files import write_text
from ecfit.microfacet import DielectricFresnel
from ecfit.progress import Progress
from ecfit.quantities import directional_albedo
from ecfit.rendering.albedo import arguments
from ecfit.rendering.pictures import by_size, percent
from ecfit.rendering.plan import TABLES, Albedos, starred
from ecfit.rendering.verdict import LEAST_MU

COLUMNS = ("material", "ior", "side", "r", "row", "approximation", "mean", "worst", "worst_mu", "energy")

# Uniform nodes of mu: the deviations of fits are smooth where mu >= LEAST_MU, those of tables have kinks at
# their own nodes, which lie closer than 1 / 60 in no shipped config.
_NODES = 61


@dataclass(frozen=True)
class Scattering:
    """How far one scattering is from keeping all energy, where mu >= 0.1.

    Attributes:
        material, ior, side, r, row, approximations: what is scattered at, and what stands for E.
        mean, energy: of |integral - 1| and of integral - 1 over the picture of a sphere: weighted with mu.
        worst, worst_mu: largest |integral - 1| and its mu.
    """

    material: str
    ior: float | None
    side: str
    r: float
    row: str
    approximations: str
    mean: float
    worst: float
    worst_mu: float
    energy: float


@dataclass(frozen=True)
class Numerical:
    """All scatterings of a config, and the CSV file that lists them."""

    scatterings: list[Scattering]
    file: Path

    def describe(self) -> list[str]:
        """Lines for people to read: the scattering of each row that deviates most."""
        out = []
        for row in dict.fromkeys(s.row for s in self.scatterings):
            far = max((s for s in self.scatterings if s.row == row), key=lambda s: by_size(s.mean))
            ior = "" if far.ior is None else f", ior = {far.ior:g}"
            side = f", {far.side}" if far.side else ""
            place = f"{far.material}{ior}{side}, r = {far.r:g}"
            out.append(f"{row}: mean deviation at most {percent(far.mean)}, of {place}")
        return out


def run_numerical(
    path: str | Path, results: str | Path = "results", *, progress: Progress | None = None
) -> Numerical:
    """Integrate one scattering of each material of a furnace's config and write `numerical.csv`.

    Needs no renderer. Raises `EcfitError` for faults in the file and unknown names.
    """
    config = read_furnace(path)
    tell = progress or Progress()
    albedos = Albedos(config, Path(results), tell)
    cases = [
        (material, ior, role)
        for material in config.materials
        if material.light == "constant"
        for ior in material.ior or [None]
        for role in _sides(material)
    ]
    found: list[Scattering] = []
    with tell.stage("integrals", len(cases)) as advance:
        for material, ior, role in cases:
            found += _scatterings(config, material, ior, role, albedos)
            advance(1)
    if not found:
        raise EcfitError(f"{path}: no material is in the constant light: there is nothing to integrate")
    file = Path(results) / config.name / "numerical.csv"
    write_text(file, summary(found))
    return Numerical(found, file)


def _sides(material: MaterialConfig) -> tuple[str, ...]:
    """The role whose deviation is looked at: both sides of glass, else the last albedo that is needed."""
    needs = NEEDS[material.model]
    return needs if material.model == "dielectric" else needs[-1:]


def _scatterings(
    config: FurnaceConfig, material: MaterialConfig, ior: float | None, role: str, albedos: Albedos
) -> Iterator[Scattering]:
    mu = np.linspace(LEAST_MU, 1.0, _NODES)
    for row in config.rows:
        used = _used(material, row, ior, albedos)
        mine = {role: used[role]} if used and material.model == "dielectric" else used
        deviation = _deviation(material.model, role, np.array(config.r), ior, mu, used)
        for r, d in zip(config.r, deviation, strict=True):
            worst = int(np.argmax(np.abs(d)))
            area = float(np.trapezoid(mu, mu))
            yield Scattering(
                material=material.name,
                ior=ior,
                side=role if material.model == "dielectric" else "",
                r=r,
                row=row.name,
                approximations=starred(mine, ior),
                mean=float(np.trapezoid(mu * np.abs(d), mu)) / area,
                worst=float(np.abs(d[worst])),
                worst_mu=float(mu[worst]),
                energy=float(np.trapezoid(mu * d, mu)) / area,
            )


def _used(
    material: MaterialConfig, row: RowConfig, ior: float | None, albedos: Albedos
) -> Mapping[str, Approximation]:
    roles = NEEDS[material.model] if row.compensates else ()
    return {role: albedos.of(row, role, ior) for role in roles}


def _deviation(
    kind: str,
    role: str,
    r: np.ndarray,
    ior: float | None,
    mu: np.ndarray,
    used: Mapping[str, Approximation],
) -> np.ndarray:
    """Integral - 1 of one scattering, r x mu."""

    def true(role: str, transport: str = "energy") -> np.ndarray:
        name, options, coordinates = TABLES[role]
        more: dict[str, Any] = {"ior": ior} if "F0" in coordinates else {}
        values = directional_albedo(
            model(name, **options), mu=mu[None, :], r=r[:, None], transport=transport, **more
        )
        return np.asarray(values)

    def taken(role: str) -> np.ndarray:
        values = [np.asarray(used[role](mu=mu, **arguments(used[role], float(x), ior))) for x in r]
        return np.array(values)

    if kind != "glossy":
        if not used:
            return true(role) - 1.0
        return true(role, used[role].contract.transport) / taken(role) - 1.0
    # E_F / E_ss + 1 - E_spec, where E_F is the true one (Sforza & Pellacini 2022, eq. 18; without: eq. 16).
    layer = true("glossy") * true("conductor")
    if not used:
        assert ior is not None
        return layer - np.asarray(DielectricFresnel(jnp.asarray(ior))(jnp.asarray(mu)))
    return layer / taken("conductor") - taken("glossy")


def summary(found: list[Scattering]) -> str:
    """Scatterings as CSV, one row each."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for s in found:
        numbers = (f"{n:.3g}" for n in (s.mean, s.worst, s.worst_mu, s.energy))
        ior = "" if s.ior is None else f"{s.ior:g}"
        writer.writerow([s.material, ior, s.side, f"{s.r:g}", s.row, s.approximations, *numbers])
    return out.getvalue()
