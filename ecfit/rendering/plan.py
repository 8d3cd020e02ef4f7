"""From the config of a furnace to its spheres: names resolved, small tables computed, nothing rendered."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ecfit.approximation import Approximation, find
from ecfit.approximation.tables import as_lookup
from ecfit.bsdf import model
from ecfit.config.furnace import NEEDS, FurnaceConfig, MaterialConfig, RowConfig
from ecfit.contract import Contract
from ecfit.coordinates import Axis, resolve, viewed
from ecfit.errors import EcfitError
from ecfit.progress import Progress
from ecfit.rendering.albedo import albedo_code
from ecfit.rendering.sphere import Sphere, joined
from ecfit.study.runner import stored_table
from ecfit.tables import Request, claim

# Absolute errors of small tables: far below those of interpolation between 32 nodes.
_TOLERANCE = 1e-6

# Role -> what is tabulated: model, options, coordinates.
TABLES: dict[str, tuple[str, dict[str, str], tuple[str, ...]]] = {
    "conductor": ("conductor", {}, ("r", "mu")),
    "glossy": ("glossy", {}, ("F0", "r", "mu")),
    "entering": ("dielectric", {"side": "entering"}, ("F0", "r", "mu")),
    "leaving": ("dielectric", {"side": "leaving"}, ("F0", "r", "mu")),
}


class Albedos:
    """The approximations of a config's rows, tables computed once and kept on disk.

    Args:
        config: the furnace.
        results: folder of all results, which shares tables with studies.
        progress: is told what is tabulated.
    """

    def __init__(self, config: FurnaceConfig, results: Path, progress: Progress) -> None:
        self._results, self._progress = results, progress
        self._iors = [i for m in config.materials if m.model == "dielectric" for i in m.ior or ()]
        self._fits: dict[str, Approximation] = {}
        self._found: dict[tuple[str, int], Approximation] = {}

    def of(self, row: RowConfig, role: str, ior: float | None) -> Approximation:
        """What stands for an albedo in a row: of several fits the first whose domain holds the ior.

        Where none does it is the last, beyond its domain.
        """
        if row.table is not None:
            return self._lookup(role, row.table)
        choices = [self._named(name) for name in getattr(row, role)]
        wanted = _contract(role)
        for choice in choices:
            # Either transport normalises the lobes of its own side.
            faults = replace(choice.contract, transport=wanted.transport).differences(wanted)
            if faults:
                said = ", ".join(f"{k} = {v}" for k, v in (("model", wanted.model), *wanted.options.items()))
                raise EcfitError(
                    f"row '{row.name}': '{choice.name}' has {', '.join(faults)}, but {role} is an albedo "
                    f"({wanted.quantity}, lobe {wanted.lobe}) of {said}: name another fit"
                )
        return next((choice for choice in choices if holds(choice, ior)), choices[-1])

    def _named(self, name: str) -> Approximation:
        if name not in self._fits:
            self._fits[name] = find(name)
        return self._fits[name]

    def _lookup(self, role: str, count: int) -> Approximation:
        if (role, count) not in self._found:
            name, options, coordinates = TABLES[role]
            axes = {c: self._axis(role, c, count) for c in coordinates}
            request = Request.make(model(name, **options), axes, tolerance=_TOLERANCE)
            self._found[role, count] = as_lookup(
                stored_table(request, role, self._results, {}, self._progress)
            )
        return self._found[role, count]

    def _axis(self, role: str, name: str, count: int) -> Axis:
        """Uniform over the whole range, of F0 of a dielectric over the iors of the config."""
        low, high = 0.0, 1.0
        if name == "F0" and role != "glossy":
            # One ior alone has no range: a table around it.
            ends = min(self._iors), max(self._iors)
            if ends[0] == ends[1]:
                ends = 1.0 + 0.9 * (ends[0] - 1.0), 1.0 + 1.1 * (ends[0] - 1.0)
            low, high = (float(resolve(["F0"], {"ior": ior})["F0"]) for ior in ends)
        return Axis.spaced(name, count, low, high)


def _contract(role: str) -> Contract:
    """What is rendered: the conventions of Mitsuba's lobes."""
    name, options, _ = TABLES[role]
    return claim(name, dict(model(name, **options).options()), "directional-albedo", "all", "energy", {})


def beyond(used: Mapping[str, Approximation], ior: float | None) -> tuple[str, ...]:
    """The roles whose approximation is used outside its domain."""
    return tuple(role for role, found in used.items() if not holds(found, ior))


def starred(used: Mapping[str, Approximation], ior: float | None) -> str:
    """Names for people; those outside their domain have a star."""
    return joined({role: found.name for role, found in used.items()}, beyond(used, ior))


def holds(approximation: Approximation, ior: float | None) -> bool:
    """Whether an approximation's domain holds an index of refraction."""
    for variable, (low, high) in zip(approximation.variables, approximation.domain, strict=True):
        value = None if ior is None else viewed(variable, "ior", ior)
        # The ends of domains are rounded numbers: F0 of ior = 3 is 0.25.
        if value is not None and not low * (1.0 - 1e-9) <= value <= high * (1.0 + 1e-9):
            return False
    return True


def spheres(config: FurnaceConfig, albedos: Albedos) -> list[Sphere]:
    """All spheres of a config, picture by picture, row by row, from left to right."""
    return [
        _sphere(config, material, row, r, ior, albedos)
        for material in config.materials
        for ior in material.ior or [None]
        for row in config.rows
        for r in config.r
    ]


def _sphere(
    config: FurnaceConfig,
    material: MaterialConfig,
    row: RowConfig,
    r: float,
    ior: float | None,
    albedos: Albedos,
) -> Sphere:
    roles = NEEDS[material.model] if row.compensates else ()
    used = {role: albedos.of(row, role, ior) for role in roles}
    return Sphere(
        material=material.name,
        row=row.name,
        model=material.model,
        light=material.light,
        r=r,
        ior=ior,
        eta=None if material.eta is None else tuple(material.eta),
        k=None if material.k is None else tuple(material.k),
        rho=tuple(material.rho or (1.0, 1.0, 1.0)),
        albedos={role: albedo_code(found, r, ior) for role, found in used.items()},
        outside=beyond(used, ior),
        pixels=material.pixels or config.pixels,
        samples=material.samples or config.samples,
        seeds=config.seeds,
        candidates=config.candidates,
        depth=config.depth,
    )
