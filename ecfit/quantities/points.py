"""From coordinates in any view to the parameters of a model."""

from ecfit.bsdf import BSDF
from ecfit.coordinates import Map, view_of
from ecfit.errors import EcfitError
from ecfit.quantities.base import Quantity


def parameter_map(model: BSDF, quantity: Quantity, name: str) -> tuple[str, Map]:
    """The model's parameter (or "mu") that the coordinate `name` stands for, and the map to it.

    Raises `EcfitError` for a name that neither the quantity nor the model (under its options) knows.
    """
    try:
        return view_of(name, (*quantity.coordinates, *quantity.parameters(model)))
    except EcfitError as error:
        if name in set(model.parameter_ranges()) - set(model.active_parameters()):
            chosen = ", ".join(f"{k} = {v}" for k, v in model.options().items())
            raise EcfitError(f"parameter '{name}' has no effect with {chosen}") from None
        if name in set(model.active_parameters()) - set(quantity.parameters(model)):
            raise EcfitError(f"parameter '{name}' has no effect on this quantity") from None
        raise error
