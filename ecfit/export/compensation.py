"""The functions that one calls beside E: what a lobe is multiplied with to keep its energy."""

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError
from ecfit.export.coordinates import Arguments
from ecfit.export.functions import Function
from ecfit.expressions import maximum, var

# 1 / E is at most 32. Conductors of every roughness have E > 0.3 and never come near; an interface of nearly
# equal indices has E < 0.06 at grazing, where one would rather lose energy than multiply by 100.
LEAST = 1.0 / 32.0

# What E of these models is divided by: their own one-bounce lobe, reflected and transmitted.
_MODELS = ("conductor", "dielectric", "thin-dielectric")


def factors(approximation: Approximation, name: str, taken: Arguments, least: float) -> list[Function]:
    """`name_factor`, 1 / E, and for a conductor `name_metal`, 1 + F0 (1 / E - 1) with a colour F0.

    Both call the function `name`. Turquin 2019; Sforza & Pellacini 2022, eq. 7, 13 and 19; see
    `ecfit.compensation.formulas.turquin_factor`.

    Args:
        least: E is raised to this before anything is divided by it, 0 < least <= 1.

    Raises `EcfitError` for what is no directional albedo of a whole one-bounce lobe, and for other `least`.
    """
    contract = approximation.contract
    whole = contract.lobe == "all" or contract.model == "conductor"
    if contract.quantity != "directional-albedo" or contract.model not in _MODELS or not whole:
        raise EcfitError(
            f"'{approximation.name}' is no albedo that a lobe is divided by: a factor 1 / E needs the "
            f"directional-albedo, lobe = all, of {', '.join(_MODELS)}"
        )
    if not 0.0 < least <= 1.0:
        raise EcfitError(f"the least E must be in (0, 1], got {least:g}")
    albedo = "E" if "E" not in (name, *taken.names) else "albedo"
    calls = {albedo: (name, taken.names)}
    safe = maximum(var(albedo), least)
    limit = f"at most {1.0 / least:.4g}"
    note = f"what the one-bounce lobe is multiplied with: 1 / E, {limit}"
    out = [Function(f"{name}_factor", taken.names, 1.0 / safe, note, calls)]
    if contract.model == "conductor":
        reflectance = "F0" if "F0" not in taken.names else "reflectance"
        metal = 1.0 + var(reflectance) * ((1.0 - safe) / safe)
        note = f"the same for a metal of the colour {reflectance}: 1 + {reflectance} (1 / E - 1)"
        names = (*taken.names, reflectance)
        out.append(Function(f"{name}_metal", names, metal, note, calls, frozenset({reflectance})))
    return out
