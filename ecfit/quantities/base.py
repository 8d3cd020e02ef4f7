"""The protocol of a quantity and the two albedos."""

import abc
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.contract import LOBES, TRANSPORTS
from ecfit.errors import unknown
from ecfit.quadrature import Estimate
from ecfit.quadrature.rules import graded, integrate_line

Array = jax.Array


class Quantity(eqx.Module):
    """A number derived from a model at a point; computed at a level of the model's measure.

    Attributes:
        lobe, transport: names of `ecfit.contract.LOBES` and `TRANSPORTS`.
    """

    lobe: str = eqx.field(static=True, default="all")
    transport: str = eqx.field(static=True, default="energy")

    # Coordinates that the quantity needs beside parameters of the model.
    coordinates: ClassVar[tuple[str, ...]] = ()

    def __check_init__(self) -> None:
        if self.lobe not in LOBES:
            raise unknown("lobe", self.lobe, LOBES)
        if self.transport not in TRANSPORTS:
            raise unknown("transport", self.transport, TRANSPORTS)

    @abc.abstractmethod
    def nodes(self, model: BSDF) -> tuple[int, ...]:
        """Evaluations of the BSDF an entry at each level: what sizes the blocks in memory."""

    @abc.abstractmethod
    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        """The quantity at one point by the rules of one level (static); mu is ignored where unused."""

    def confirm(self, model: BSDF) -> bool:
        """Whether an estimate counts only once the next level agrees (see `Measure.confirm`)."""
        return model.measure().confirm

    def directional(self, model: BSDF, mu: Array, level: int) -> Estimate:
        """The directional albedo of the chosen lobe in the chosen transport."""
        measure = model.measure()
        if self.transport == "radiance" or not model.transmissive or self.lobe == "reflection":
            return measure.albedo(mu, level, self.lobe)
        eta = model.relative_ior()
        transmitted = jax.tree.map(lambda v: eta * eta * v, measure.albedo(mu, level, "transmission"))
        if self.lobe == "transmission":
            return transmitted
        return jax.tree.map(jnp.add, measure.albedo(mu, level, "reflection"), transmitted)


class DirectionalAlbedo(Quantity):
    """E(mu) (Sforza & Pellacini 2022, eq. 2)."""

    coordinates: ClassVar[tuple[str, ...]] = ("mu",)

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        return model.measure().levels

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        return self.directional(model, mu, level)


class AverageAlbedo(Quantity):
    """E_avg = 2 x integral of E(mu) mu dmu over [0, 1] (Sforza & Pellacini 2022, eq. 5)."""

    def confirm(self, model: BSDF) -> bool:
        # E(mu) turns within mu ~ alpha, which may fall between the nodes of the average.
        return True

    @staticmethod
    def _count(level: int) -> int:
        return 8 + 6 * level

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        return tuple(n * self._count(i) for i, n in enumerate(model.measure().levels))

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        # mu = t^2: E changes fastest within mu ~ alpha of grazing.
        rule = graded(0, self._count(level))
        t = jnp.asarray(rule.nodes)
        albedo = jax.vmap(lambda m: self.directional(model, m, level))(t * t)
        weight = 4.0 * t**3
        average = integrate_line(weight * albedo.value, rule)
        return Estimate(average.value, average.error + jnp.asarray(rule.weights) @ (weight * albedo.error))


_QUANTITIES: dict[str, type[Quantity]] = {
    "directional-albedo": DirectionalAlbedo,
    "average-albedo": AverageAlbedo,
}


def quantity(name: str, lobe: str = "all", transport: str = "energy") -> Quantity:
    """The quantity of that name; raises `EcfitError` for an unknown name, lobe or transport."""
    if name not in _QUANTITIES:
        raise unknown("quantity", name, _QUANTITIES)
    return _QUANTITIES[name](lobe, transport)
