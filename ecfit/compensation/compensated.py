"""Models that put the lost energy of another model back: BSDFs like any other.

The albedo that compensates is an approximation (a fit, a published fit), as in a renderer, or by default
the exact integral.
"""

import abc
from collections.abc import Mapping
from typing import Any

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.approximation import Approximation
from ecfit.bsdf import BSDF, as_model
from ecfit.compensation.formulas import kulla_conty_lobe, turquin_factor
from ecfit.compensation.lookup import albedo_of, coordinates_of
from ecfit.contract import TRANSPORTS
from ecfit.errors import EcfitError, unknown
from ecfit.quadrature import Estimate, Measure
from ecfit.quadrature.rules import graded
from ecfit.quantities import DirectionalAlbedo

Array = jax.Array

# Nodes in t = sqrt(mu) of integrals of a smooth albedo over mu.
_NODES = 48


class _Measure(Measure):
    """The measure of a compensated model: that of its base, and the energy that the model puts back."""

    model: "Compensated"

    @property
    def default_level(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        return self.model.base.measure().default_level

    @property
    def confirm(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        return self.model.base.measure().confirm

    @property
    def levels(self) -> tuple[int, ...]:
        # The exact albedo is a second integral, and the lobe takes one for each of its nodes.
        return tuple(n * self.model.integrals for n in self.model.base.measure().levels)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        return self.model.restored(mu, self.model.base.measure().albedo(mu, level, lobe), level, lobe)


class Compensated(BSDF):
    """A base model with its lost energy put back by the albedo of the whole base.

    Attributes:
        base: the single-scattering model.
        given: approximation of its albedo (lobe = all); None for the exact integral.
        transport: in which the exact albedo is taken.

    Raises `EcfitError` for an unknown transport.
    """

    base: BSDF
    given: Approximation | None = eqx.field(static=True, default=None)
    transport: str = eqx.field(static=True, default="energy")

    def __check_init__(self) -> None:
        if self.given is not None:
            coordinates_of(self.given, self.base)
        if self.transport not in TRANSPORTS:
            raise unknown("transport", self.transport, TRANSPORTS)

    @property
    @abc.abstractmethod
    def integrals(self) -> int:
        """Albedos that one value of the measure takes."""

    @abc.abstractmethod
    def restored(self, mu: Array, single: Estimate, level: int, lobe: str) -> Estimate:
        """The albedo of a lobe after compensation from that before it."""

    def E(self, mu: Array, level: int | None = None) -> Array:
        """The albedo that compensates, at mu."""
        approximated = albedo_of(self.given, self.base, mu)
        if approximated is not None:
            return approximated
        level = self.base.measure().default_level if level is None else level
        return DirectionalAlbedo("all", self.transport).directional(self.base, mu, level).value

    def measure(self) -> Measure:
        return _Measure(self)

    @property
    def transmissive(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        return self.base.transmissive

    @property
    def fresnel_parameters(self) -> tuple[str, ...]:  # pyright: ignore[reportIncompatibleVariableOverride]
        return self.base.fresnel_parameters

    def relative_ior(self) -> Array:
        return self.base.relative_ior()

    def edges(self, mu: Array) -> Array:
        return self.base.edges(mu)

    def albedo_kinks(self) -> Array:
        return self.base.albedo_kinks()

    def parameter_ranges(self) -> dict[str, tuple[float, float]]:  # pyright: ignore
        return self.base.parameter_ranges()

    def active_parameters(self) -> tuple[str, ...]:
        return self.base.active_parameters()

    def parameter_value(self, name: str) -> Array:
        return self.base.parameter_value(name)

    def with_parameters(self, values: Mapping[str, Array]) -> "BSDF":
        return eqx.tree_at(lambda m: m.base, self, self.base.with_parameters(values))

    def options(self) -> dict[str, str]:
        albedo = "exact" if self.given is None else self.given.name
        return {**self.base.options(), "compensation": type(self).__name__, "albedo": albedo}


class Turquin(Compensated):
    """The base scaled by 1 + F0 (1 - E) / E (Sforza & Pellacini 2022, eq. 13; with F0 = 1 eq. 7 and 19)."""

    F0: Array = eqx.field(default=1.0, converter=lambda v: jnp.asarray(v, dtype=jnp.float64))

    reciprocal = False
    # An E that is too small adds energy.
    conserving = False

    @property
    def integrals(self) -> int:
        return 2 if self.given is None else 1

    def f(self, wo: Array, wi: Array) -> Array:
        return turquin_factor(self.E(wo[2]), self.F0) * self.base.f(wo, wi)

    def restored(self, mu: Array, single: Estimate, level: int, lobe: str) -> Estimate:
        factor = turquin_factor(self.E(mu, level), self.F0)
        return Estimate(factor * single.value, jnp.abs(factor) * single.error)


class KullaConty(Compensated):
    """The base plus the diffuse lobe of Sforza & Pellacini 2022, eq. 4, for a reflecting base.

    Raises `EcfitError` for a model that transmits.
    """

    average: Approximation | None = eqx.field(static=True, default=None)
    F_ms: Array = eqx.field(default=1.0, converter=lambda v: jnp.asarray(v, dtype=jnp.float64))

    conserving = False

    def __check_init__(self) -> None:
        if self.base.transmissive:
            raise EcfitError("the Kulla-Conty lobe is for reflection: this model transmits")
        if self.average is not None:
            coordinates_of(self.average, self.base)

    @property
    def integrals(self) -> int:
        return 1 + (1 + _NODES if self.given is None else 0)

    def f(self, wo: Array, wi: Array) -> Array:
        average, _ = self._averages(None)
        lost = average < 1.0
        lobe = kulla_conty_lobe(self.E(wo[2]), self.E(wi[2]), jnp.where(lost, average, 0.0), self.F_ms)
        return self.base.f(wo, wi) + jnp.where(lost & (wi[2] > 0.0), lobe, 0.0)

    def restored(self, mu: Array, single: Estimate, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return single
        average, integral = self._averages(level)
        lost = average < 1.0
        share = (1.0 - integral) / jnp.where(lost, 1.0 - average, 1.0)
        added = jnp.where(lost, self.F_ms * (1.0 - self.E(mu, level)) * share, 0.0)
        return Estimate(single.value + added, single.error)

    def _averages(self, level: int | None) -> tuple[Array, Array]:
        """E_avg as a renderer has it, and the true average of the E in use (eq. 5)."""
        rule = graded(0, _NODES)
        t = jnp.asarray(rule.nodes)
        integral = jnp.asarray(rule.weights) @ (4.0 * t**3 * jax.vmap(lambda m: self.E(m, level))(t * t))
        given = albedo_of(self.average, self.base, jnp.asarray(1.0))
        return (integral if given is None else given), integral


_METHODS = {"turquin": Turquin, "kulla-conty": KullaConty}


def compensate(
    model: BSDF | type[BSDF] | str,
    albedo: Approximation | None = None,
    method: str = "turquin",
    **settings: Any,
) -> Compensated:
    """A model with its energy put back.

    Args:
        model: the single-scattering BSDF: a white conductor, a dielectric, a user's own.
        albedo: approximation of its directional albedo (lobe = all); None for the exact integral.
        method: "turquin" (scaled) or "kulla-conty" (a diffuse lobe added, reflection only).
        settings: `F0` of "turquin"; `average` (an approximation of E_avg) and `F_ms` of "kulla-conty";
            `transport` in which an exact albedo is taken.

    Raises `EcfitError` for an unknown method, and an approximation of coordinates that the model lacks.
    """
    if method not in _METHODS:
        raise unknown("compensation", method, _METHODS)
    try:
        return _METHODS[method](base=as_model(model), given=albedo, **settings)
    except TypeError:
        raise EcfitError(f"compensation '{method}' does not take {', '.join(settings)}") from None
