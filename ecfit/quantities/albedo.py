"""The directional albedo as a plain JAX function."""

from typing import Any

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF, as_model
from ecfit.errors import EcfitError
from ecfit.quantities.base import DirectionalAlbedo
from ecfit.quantities.points import parameter_map

Array = jax.Array

# Points integrated at once: bounds memory for long inputs.
_BATCH = 512


def directional_albedo(
    model: BSDF | type[BSDF] | str,
    *,
    lobe: str = "all",
    transport: str = "energy",
    level: int | None = None,
    **coordinates: Any,
) -> Array:
    """The directional albedo E of a model at given points, by a rule of fixed level.

    Args:
        model: a BSDF or a registered name.
        lobe: "all", "reflection" or "transmission".
        transport: "energy" or "radiance".
        level: level of the model's measure; by default one that is good to about 1e-8 for microfacet
            reflection. `ecfit.tabulate` refines and estimates errors.
        coordinates: `mu` in [0, 1], and any parameters of the model, in any view (`r` or `alpha`, ...).
            Arrays broadcast; parameters not given keep the model's values.

    Returns the albedo, float64, of the broadcast shape. Works under jit, vmap and grad (in the
    coordinates and in the model's own fields). Raises `EcfitError` for unknown names.
    """
    bsdf = as_model(model)
    quantity = DirectionalAlbedo(lobe, transport)
    if "mu" not in coordinates:
        raise EcfitError("directional_albedo needs the coordinate mu")
    count = len(quantity.nodes(bsdf))
    if level is None:
        level = bsdf.measure().default_level
    if not 0 <= level < count:
        raise EcfitError(f"level must be in 0..{count - 1}, got {level}")
    given: dict[str, Array] = {}
    for name, value in coordinates.items():
        parameter, map_ = parameter_map(bsdf, quantity, name)
        if parameter in given:
            raise EcfitError(f"parameter '{parameter}' given more than once")
        given[parameter] = map_.forward(jnp.asarray(value, dtype=jnp.float64))
    shape = jnp.broadcast_shapes(*(v.shape for v in given.values()))
    flat = {n: jnp.broadcast_to(v, shape).ravel() for n, v in given.items()}
    return _albedo(bsdf, quantity, level, flat).reshape(shape)


@eqx.filter_jit
def _albedo(bsdf: BSDF, quantity: DirectionalAlbedo, level: int, flat: dict[str, Array]) -> Array:
    def one(point: dict[str, Array]) -> Array:
        mu = point["mu"]
        return quantity.estimate(
            bsdf.with_parameters({n: v for n, v in point.items() if n != "mu"}), mu, level
        ).value

    if flat["mu"].size <= _BATCH:
        return jax.vmap(one)(flat)
    return jax.lax.map(one, flat, batch_size=_BATCH)
