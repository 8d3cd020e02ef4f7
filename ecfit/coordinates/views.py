"""Views: the names under which one parameter of a model may be given (r for alpha, F0 for ior).

This is the only place that relates r to alpha or F0 to the index of refraction.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ecfit.coordinates.maps import MAPS, Map
from ecfit.errors import EcfitError, did_you_mean

Array = Any


@dataclass(frozen=True)
class View:
    """`name` is another coordinate for the parameter `of`: parameter = map.forward(name)."""

    name: str
    of: str
    map: Map


VIEWS: dict[str, View] = {
    v.name: v
    for v in (
        View("r", "alpha", MAPS["square"]),
        View("F0", "ior", MAPS["F0-to-ior"]),
    )
}


def view_of(name: str, parameters: Collection[str]) -> tuple[str, Map]:
    """The parameter that the coordinate `name` stands for, and the map from the coordinate to it.

    A model's own parameter of that name wins over a view. Raises `EcfitError` where there is neither.
    """
    if name in parameters:
        return name, MAPS["identity"]
    if name in VIEWS and VIEWS[name].of in parameters:
        return VIEWS[name].of, VIEWS[name].map
    valid = sorted(parameters) + sorted(v.name for v in VIEWS.values() if v.of in parameters)
    raise EcfitError(
        f"no coordinate '{name}' here: expected one of {', '.join(valid)}{did_you_mean(name, valid)}"
    )


def viewed(name: str, given: str, values: Array) -> Array | None:
    """The coordinate `name` at values of the coordinate `given`; None where neither is a view of the other.

    `viewed("r", "alpha", 0.25)` is 0.5.
    """
    try:
        return resolve([name], {given: values})[name]
    except EcfitError:
        return None


def resolve(names: Iterable[str], given: Mapping[str, Array]) -> dict[str, Array]:
    """The coordinates `names` from the `given` ones, each of which may be in another view.

    `resolve(["r", "mu"], {"alpha": 0.25, "mu": 1.0})` is `{"r": 0.5, "mu": 1.0}`.
    Raises `EcfitError` for a coordinate that is missing, given twice or not asked for.
    """
    names = list(names)
    left = dict(given)
    out: dict[str, Array] = {}
    for name in names:
        readings: dict[str, Array] = {}
        if name in left:
            readings[name] = left.pop(name)
        if name in VIEWS and VIEWS[name].of in left:
            parameter = VIEWS[name].of
            readings[parameter] = VIEWS[name].map.inverse(left.pop(parameter))
        for view in VIEWS.values():
            if view.of == name and view.name in left:
                readings[view.name] = view.map.forward(left.pop(view.name))
        if len(readings) > 1:
            raise EcfitError(f"coordinate '{name}' given more than once: as {' and '.join(readings)}")
        if not readings:
            raise EcfitError(f"coordinate '{name}' is missing: expected {', '.join(names)}")
        out[name] = next(iter(readings.values()))
    if left:
        raise EcfitError(f"coordinate '{next(iter(left))}' is not used here: expected {', '.join(names)}")
    return out
