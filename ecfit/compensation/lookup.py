"""An approximation evaluated at a model's own parameters."""

from ecfit._jax import jax
from ecfit.approximation import Approximation
from ecfit.bsdf import BSDF
from ecfit.coordinates import VIEWS
from ecfit.errors import EcfitError

Array = jax.Array


def coordinates_of(approximation: Approximation, model: BSDF) -> tuple[str, ...]:
    """The model's parameters, "mu" apart, that the approximation needs.

    Raises `EcfitError` where it needs another one.
    """
    out = []
    known = model.active_parameters()
    for name in approximation.variables:
        parameter = name if name in known or name not in VIEWS else VIEWS[name].of
        if parameter in known:
            out.append(parameter)
        elif name != "mu":
            raise EcfitError(
                f"'{approximation.name}' is a function of {', '.join(approximation.variables)}, but "
                f"{type(model).__name__} has no parameter '{name}'"
            )
    return tuple(out)


def albedo_of(approximation: Approximation | None, model: BSDF, mu: Array) -> Array | None:
    """The approximation at mu and the model's parameters; None for none."""
    if approximation is None:
        return None
    given = {name: model.parameter_value(name) for name in coordinates_of(approximation, model)}
    if "mu" in approximation.variables:
        given["mu"] = mu
    return approximation(**given)
