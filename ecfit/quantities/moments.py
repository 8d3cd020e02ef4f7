"""Moments of a reflection lobe: means of functions of x = wo.h, from which other Fresnel factors follow.

The distribution of x at given (alpha, mu) does not depend on the Fresnel factor, so that a few moments serve
every F0 and F90: E = F0 A + F90 B with Schlick's factor, less b times the F82 moment with F82 tint
(Kutz et al. 2021).
"""

import abc
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.errors import EcfitError
from ecfit.microfacet import Fresnel, SchlickFresnel
from ecfit.quadrature import Estimate, HalfVectorReflection
from ecfit.quadrature.rules import graded, integrate_line
from ecfit.quantities.base import Quantity

Array = jax.Array


class Moment(Quantity):
    """The integral of a function of x = wo.h over the lobe of a microfacet reflection, in place of F."""

    coordinates: ClassVar[tuple[str, ...]] = ("mu",)

    @abc.abstractmethod
    def factor(self) -> Fresnel:
        """The function of x."""

    def _rule(self, model: BSDF) -> HalfVectorReflection:
        measure = model.measure()
        if not isinstance(measure, HalfVectorReflection):
            raise EcfitError(
                f"{type(model).__name__} is not one microfacet reflection lobe: moments of wo.h are defined "
                "for models such as 'conductor'"
            )
        return measure.with_factor(self.factor())

    def parameters(self, model: BSDF) -> tuple[str, ...]:
        return tuple(n for n in model.active_parameters() if n not in model.fresnel_parameters)

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        return self._rule(model).levels

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        return self._rule(model).albedo(mu, level, self.lobe)


class SchlickB(Moment):
    """B: the mean of (1 - x)^exponent.

    Raises `EcfitError` for an exponent outside 1..50.
    """

    exponent: int = eqx.field(static=True, default=5)

    def __check_init__(self) -> None:
        if (
            not isinstance(self.exponent, int)
            or isinstance(self.exponent, bool)
            or not 1 <= self.exponent <= 50
        ):
            raise EcfitError(f"exponent must be an integer in 1..50, got {self.exponent!r}")

    def options(self) -> dict[str, int]:
        return {"exponent": self.exponent}

    def factor(self) -> Fresnel:
        return SchlickFresnel(jnp.asarray(0.0), jnp.asarray(1.0), self.exponent)


class SchlickA(SchlickB):
    """A: the mean of 1 - (1 - x)^exponent."""

    def factor(self) -> Fresnel:
        return SchlickFresnel(jnp.asarray(1.0), jnp.asarray(0.0), self.exponent)


class _F82(Fresnel):
    def __call__(self, x: Array) -> Array:
        return x * (1.0 - x) ** 6


class F82Moment(Moment):
    """The mean of x (1 - x)^6."""

    def factor(self) -> Fresnel:
        return _F82()


class AverageFresnel(Quantity):
    """F_avg = 2 x integral of F(x) x dx over [0, 1] (Kulla & Conty 2017): it does not depend on roughness."""

    # Nodes of each level.
    ORDERS: ClassVar[tuple[int, ...]] = (24, 40, 64, 96, 144)

    def parameters(self, model: BSDF) -> tuple[str, ...]:
        return tuple(n for n in model.active_parameters() if n != "alpha")

    def nodes(self, model: BSDF) -> tuple[int, ...]:
        return self.ORDERS

    def confirm(self, model: BSDF) -> bool:
        return True

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        fresnel = getattr(model, "fresnel_factor", None)
        if fresnel is None:
            raise EcfitError(f"{type(model).__name__} has no Fresnel factor to average")
        # Below the critical cosine F = 1; above it 1 - F has a root, and for eta near 1 F falls fast.
        eta = jnp.minimum(model.relative_ior(), 1.0)
        square = (1.0 - eta) * (1.0 + eta)
        critical = jnp.where(square > 0.0, jnp.sqrt(jnp.where(square > 0.0, square, 1.0)), 0.0)
        rule = graded(0, self.ORDERS[level])
        u = jnp.asarray(rule.nodes)
        # u^4: near grazing F has the scale sqrt(eta^2 - 1), which may be small.
        width = 1.0 - critical
        x = critical + width * u**4
        found = integrate_line(2.0 * fresnel()(x) * x * width * 4.0 * u**3, rule)
        return Estimate(jnp.maximum(square, 0.0) + found.value, found.error)
