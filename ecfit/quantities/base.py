"""The protocol of a quantity, and the two albedos."""

import abc
from collections.abc import Mapping
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.contract import LOBES, TRANSPORTS
from ecfit.errors import unknown
from ecfit.quadrature import CosineRule, Estimate, cosine_count

Array = jax.Array


class Quantity(eqx.Module):
    """A number derived from a model at a point; computed at a level of the model's measure.

    Attributes:
        lobe, transport: names of `ecfit.contract.LOBES` and `TRANSPORTS`.

    Raises `EcfitError` for an unknown lobe or transport.
    """

    lobe: str = eqx.field(static=True, default="all")
    transport: str = eqx.field(static=True, default="energy")

    # Coordinates that the quantity needs beside parameters of the model.
    coordinates: ClassVar[tuple[str, ...]] = ()

    @staticmethod
    def range_of(coordinate: str) -> tuple[float, float]:
        """(low, high) of one of `coordinates`: [0, 1] for cosines of polar angles."""
        return (-1.0, 1.0) if coordinate == "cos_phi" else (0.0, 1.0)

    def parameters(self, model: BSDF) -> tuple[str, ...]:
        """Names of the model's parameters that matter."""
        return model.active_parameters()

    def options(self) -> dict[str, int]:
        """Settings of the quantity beside lobe and transport, for the contract."""
        return {}

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
        """The quantity at one point by the rules of one level (static); mu is ignored where unused.

        Raises `EcfitError` for a model without what the quantity is made of (a Fresnel factor, a bounce).
        """

    def estimate_at(self, model: BSDF, point: Mapping[str, Array], level: int) -> Estimate:
        """The quantity at values of its `coordinates`, for those that need others than mu."""
        return self.estimate(model, point.get("mu", jnp.asarray(1.0)), level)

    def bounded(self, model: BSDF) -> bool:
        """Whether the quantity lies in [0, 1] by the model's claim to conserve energy."""
        return model.conserving and (self.transport == "energy" or not model.transmissive)

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


class CosineIntegral(Quantity):
    """An integral over mu in [0, 1] of a weight times something linear in the directional albedo E(mu)."""

    @abc.abstractmethod
    def weight(self, mu: Array) -> Array:
        """What multiplies `of(E)`, shape of mu."""

    @abc.abstractmethod
    def of(self, albedo: Array) -> Array:
        """E or 1 - E."""

    def confirm(self, model: BSDF) -> bool:
        # E(mu) turns within mu ~ alpha, which may fall between the nodes of the integral.
        return True

    def _count(self, level: int) -> int:
        return cosine_count(level)

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        pieces = 1 + model.albedo_kinks().size
        return tuple(n * self._count(i) * pieces for i, n in enumerate(model.measure().levels))

    def rule(self, model: BSDF, level: int) -> CosineRule:
        """The nodes over mu."""
        return CosineRule.between(self._count(level), model.albedo_kinks())

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        rule = self.rule(model, level)
        return rule.integral(lambda m: self.directional(model, m, level), self.weight(rule.mu), self.of)


class AverageAlbedo(CosineIntegral):
    """E_avg = 2 x integral of E(mu) mu dmu over [0, 1] (Sforza & Pellacini 2022, eq. 5)."""

    def weight(self, mu: Array) -> Array:
        return 2.0 * mu

    def of(self, albedo: Array) -> Array:
        return albedo
