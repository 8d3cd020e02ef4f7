"""What a structured fit sees: a table's entries as weighted points, and guards on the closed domain."""

from collections.abc import Mapping, Sequence

import numpy as np

from ecfit.coordinates import Axis, viewed
from ecfit.errors import EcfitError
from ecfit.forms.features import COORDINATES
from ecfit.tables import Table

# Guards an axis; clustered towards 0, where the corner is.
_GUARDS, _OTHERS = {"mu": 13, "alpha": 13}, 6
# Directions t = alpha / (alpha + mu), and distances rho, of the guards at the corner. 1e-12 stands for 0:
# features of the chart differ by less than rounding.
_DIRECTIONS = 25
_DISTANCES = (1e-12, 1e-3, 1e-2, 5e-2)


def weights_of(axis: Axis) -> np.ndarray:
    """Weights of an axis's nodes: of the Gauss rule (uniform in the axis's own map), otherwise equal."""
    if axis.spacing == "gauss":
        return 0.5 * np.polynomial.legendre.leggauss(len(axis))[1]
    return np.full(len(axis), 1.0 / len(axis))


def table_points(table: Table) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Coordinates of structured forms of all entries (those that the table has), and their weights, flat.

    Raises `EcfitError` for an axis that is none of them in any view.
    """
    points: dict[str, np.ndarray] = {}
    weights = np.ones(1)
    mesh = np.meshgrid(*(a.nominal for a in table.axes), indexing="ij")
    for axis, values in zip(table.axes, mesh, strict=True):
        found = {name: viewed(name, axis.name, values) for name in COORDINATES}
        known = {name: np.asarray(v).ravel() for name, v in found.items() if v is not None}
        if not known:
            raise EcfitError(
                f"axis '{axis.name}' is no coordinate of structured forms: {', '.join(COORDINATES)}"
            )
        points |= known
        weights = np.multiply.outer(weights, weights_of(axis))
    return points, weights.ravel()


def check_coordinates(variables: Sequence[str], axes: Sequence[Axis]) -> None:
    """Raise `EcfitError` unless the variables of a form are those of a table, each of an axis of its own."""
    free = list(axes)
    for name in variables:
        axis = next((a for a in free if viewed(name, a.name, a.nominal) is not None), None)
        if axis is None:
            free = list(axes)
            break
        free.remove(axis)
    if free:
        raise EcfitError(
            f"the form is a function of {', '.join(variables)}, the table of "
            f"{', '.join(a.name for a in axes)}: choose features of the table's coordinates"
        )


def guard_points(domain: Mapping[str, tuple[float, float]]) -> dict[str, np.ndarray]:
    """Points over a closed domain of coordinates, and at its corner alpha = mu = 0."""
    axes = []
    for name, (low, high) in domain.items():
        t = 0.5 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, _GUARDS.get(name, _OTHERS))))
        axes.append(low + (high - low) * (t * t if name in ("mu", "alpha") else t))
    mesh = [m.ravel() for m in np.meshgrid(*axes, indexing="ij")]
    points = dict(zip(domain, mesh, strict=True))
    if "mu" in domain and "alpha" in domain:
        keep = points["alpha"] + points["mu"] > 0.0
        points = {n: p[keep] for n, p in points.items()}
        t = np.linspace(0.0, 1.0, _DIRECTIONS)
        rest = [(n, axes[i]) for i, n in enumerate(domain) if n not in ("mu", "alpha")]
        corner = np.meshgrid(np.array(_DISTANCES), t, *(a for _, a in rest), indexing="ij")
        rho, t, *others = (c.ravel() for c in corner)
        extra = {
            "alpha": rho * t,
            "mu": rho * (1.0 - t),
            **{n: o for (n, _), o in zip(rest, others, strict=True)},
        }
        points = {n: np.concatenate([points[n], extra[n]]) for n in points}
    return points
