"""The coordinates that an exported function takes: in which view, in which order, clamped or not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ecfit.approximation import Approximation
from ecfit.coordinates import MAPS, VIEWS, viewed
from ecfit.errors import EcfitError, did_you_mean
from ecfit.expressions import Node, maximum, minimum, parse, substitute, var
from ecfit.expressions.node import with_roots

# First mu, then the roughness, then the reflectance, then all others in the order of the form.
_ORDER = ("mu", "alpha", "r", "F0", "ior")

MEANINGS = {
    "mu": "cosine of the angle between the surface normal and the direction",
    "mu_i": "cosine of the angle between the surface normal and the other direction",
    "cos_phi": "cosine of the azimuth between both directions",
    "alpha": "width of the distribution of facets: r^2",
    "r": "perceptual roughness: sqrt(alpha)",
    "F0": "reflectance at normal incidence: ((ior - 1) / (ior + 1))^2 of a dielectric",
    "F90": "reflectance at grazing incidence",
    "ior": "index of refraction of the denser side, relative to the other",
    "sigma": "spread of the facets' slope angle in rad",
    "diffuse_roughness": "roughness of the diffuse lobe",
    "rho": "reflectance of the facets",
    "tint": "reflectance at about 82 degrees, divided by Schlick's there",
}


@dataclass(frozen=True)
class Arguments:
    """What a function takes.

    Attributes:
        names: in order.
        domain: (low, high) of each.
        transform: from an expression in the form's own variables to one in these.
    """

    names: tuple[str, ...]
    domain: tuple[tuple[float, float], ...]
    transform: Callable[[Node], Node]


def arguments(approximation: Approximation, wanted: Sequence[str], clamped: bool) -> Arguments:
    """The arguments of a function for an approximation.

    Args:
        wanted: coordinates in which it shall be given, such as ("r", "ior"); others stay as they are.
        clamped: whether the function clamps them to the domain.

    Raises `EcfitError` for a coordinate that is no view of any variable, and for two views of one.
    """
    put: dict[Node, Node] = {}
    found: dict[str, tuple[float, float]] = {}
    left = list(dict.fromkeys(wanted))
    for variable, (low, high) in zip(approximation.variables, approximation.domain, strict=True):
        name = next((w for w in left if viewed(variable, w, 0.5) is not None), variable)
        if name in left:
            left.remove(name)
            also = next((w for w in left if viewed(variable, w, 0.5) is not None), None)
            if also is not None:
                raise EcfitError(
                    f"'{name}' and '{also}' are two views of one coordinate: ask for one of them"
                )
        found[name] = _viewed(name, variable, low), _viewed(name, variable, high)
        if name != variable:
            put[var(variable)] = _view(variable, name)
    if left:
        valid = _choices(approximation.variables)
        raise EcfitError(
            f"'{approximation.name}' has no coordinate '{left[0]}': expected one of {', '.join(valid)}"
            f"{did_you_mean(left[0], valid)}"
        )
    names = tuple(sorted(found, key=lambda n: _ORDER.index(n) if n in _ORDER else len(_ORDER)))
    inside = {n: minimum(maximum(var(n), found[n][0]), found[n][1]) for n in names} if clamped else {}

    def transform(node: Node) -> Node:
        return substitute(with_roots(node, put), inside)

    return Arguments(names, tuple(found[n] for n in names), transform)


def _viewed(name: str, variable: str, end: float) -> float:
    """An end of a variable's range in the view `name`."""
    value = viewed(name, variable, end)
    assert value is not None
    return float(value)


def _view(variable: str, name: str) -> Node:
    """The variable as an expression of the coordinate `name`."""
    if variable in VIEWS and VIEWS[variable].of == name:
        return _formula(MAPS[VIEWS[variable].map.name].inverse_formula, "y", name)
    return _formula(VIEWS[name].map.formula, "x", name)


def _formula(text: str, argument: str, name: str) -> Node:
    """The right side of a map's formula, of the coordinate `name`."""
    right = text.partition("= ")[2].replace("^", "**")
    return substitute(parse(right, (argument,)), {argument: var(name)})


def _choices(variables: Sequence[str]) -> list[str]:
    others = [n for v in VIEWS.values() for n in (v.name, v.of)]
    return [*variables, *(n for n in others if n not in variables
                          and any(viewed(v, n, 0.5) is not None for v in variables))]  # fmt: skip
