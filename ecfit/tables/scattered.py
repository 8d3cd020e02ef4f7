"""Integration at scattered points: the truth for samples that lie on no grid."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ecfit.bsdf import BSDF, model
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.quadrature.refine import refine
from ecfit.quantities import Quantity, parameter_map, quantity
from ecfit.tables.tabulate import evaluator, within_bounds


class Scattered(NamedTuple):
    """Values, error estimates (absolute) and `ecfit.quadrature.Status`, shape (points,)."""

    values: np.ndarray
    errors: np.ndarray
    status: np.ndarray


def of_contract(contract: Contract) -> tuple[BSDF, Quantity]:
    """The model and the quantity that a contract names.

    Raises `EcfitError` where the model is unknown or not registered, or knows no such setting.
    """
    if contract.model == "unknown":
        raise EcfitError("the contract names no model: there is nothing to integrate")
    bsdf = model(contract.model, **{**contract.options, **contract.parameters})
    settings = {name: int(value) for name, value in contract.quantity_options.items()}
    return bsdf, quantity(contract.quantity, contract.lobe, contract.transport, **settings)


def integrate(contract: Contract, points: Mapping[str, np.ndarray], tolerance: float = 1e-8) -> Scattered:
    """A quantity at points, each refined until its error estimate meets the tolerance.

    Args:
        contract: of what; see `of_contract`.
        points: values of mu and of the model's parameters in any view, one array (points,) each.
        tolerance: absolute error to reach.

    Raises `EcfitError` for a contract without a registered model, for coordinates that it does not know
    and for points outside its domain.
    """
    bsdf, quantity_ = of_contract(contract)
    arrays: dict[str, np.ndarray] = {}
    for name, values in points.items():
        parameter, map_ = parameter_map(bsdf, quantity_, name)
        if parameter in arrays:
            raise EcfitError(f"coordinate '{parameter}' given more than once")
        given = np.asarray(map_.forward(np.asarray(values, dtype=np.float64)))
        ranges = {n: quantity_.range_of(n) for n in quantity_.coordinates} | dict(bsdf.parameter_ranges())
        low, high = ranges[parameter]
        if given.ndim != 1 or not np.all((low <= given) & (given <= high)):
            raise EcfitError(f"points of '{name}' must be an array within [{low:g}, {high:g}] of {parameter}")
        arrays[parameter] = given
    missing = [name for name in quantity_.coordinates if name not in arrays]
    if missing or len({a.size for a in arrays.values()}) != 1:
        raise EcfitError("points must be arrays of one length, " + ", ".join([*missing, "and of one each"]))
    count = next(iter(arrays.values())).size
    if count == 0:
        return Scattered(np.empty(0), np.empty(0), np.empty(0, dtype=np.int8))

    def gather(rows: np.ndarray) -> list[np.ndarray]:
        return [a[rows] for a in arrays.values()]

    evaluate = evaluator(bsdf, quantity_, tuple(arrays), gather, None, np.zeros(1))
    levels = len(quantity_.nodes(bsdf))
    done = refine(evaluate, (count, 1), levels, tolerance, quantity_.confirm(bsdf))
    values = within_bounds(bsdf, quantity_, done.values, done.errors)
    return Scattered(values[:, 0], done.errors[:, 0], done.status[:, 0])
