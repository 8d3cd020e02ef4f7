"""`BSDF`: the interface between a shading model and everything else in ecfit."""

import abc
import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError, unknown
from ecfit.quadrature import Estimate, Hemisphere, Measure

Array = jax.Array


def _as_float64(value: Any) -> Any:
    return jnp.asarray(value, dtype=jnp.float64)


def parameter(default: float, low: float, high: float, doc: str) -> Any:
    """A field of a model that can be an axis of a table: a number in [low, high].

    Args:
        default: its value where none is given.
        low, high: the range, ends included, in the parameter's own unit; also the default range of an axis.
        doc: what it is, for `ecfit list` and reports.

    A parameter named `alpha` may be given as `r`, one named `ior` as `F0`. The field holds a float64 array, a
    scalar, through which JAX differentiates.
    """
    return eqx.field(default=default, converter=_as_float64, metadata={"range": (low, high), "doc": doc})


def option(default: str, choices: tuple[str, ...], doc: str) -> Any:
    """A field of a model that is one of several words, fixed when the model is made.

    Args:
        default: the word where none is given.
        choices: all words; making a model with another raises `EcfitError`.
        doc: what is chosen, for `ecfit list`.

    The field is static: JAX compiles each choice by itself, so `f` may branch on it in plain Python.
    """
    return eqx.field(default=default, static=True, metadata={"choices": choices, "doc": doc})


class BSDF(eqx.Module):
    """A scattering model: an Equinox module with one required method, `f`.

    Declare what may vary with `ecfit.parameter` (an axis of a table; differentiable) and what is chosen
    once with `ecfit.option`. Everything else (tables, fits, reports, checks) follows from `f`.

    Class attributes (claims that `ecfit.check_bsdf` verifies):
        reciprocal: f(wo, wi) = f(wi, wo) for reflection.
        transmissive: f may be non-zero for wi on the other side; set it to False to save that integral.
        conserving: the albedo never exceeds 1.
        fresnel_parameters: parameters that enter the integrand through the Fresnel factor only: a table's
            entries that differ in one of them share the geometry, which makes them cheap.

    Raises `EcfitError` where an option is none of its choices.
    """

    reciprocal: ClassVar[bool] = True
    transmissive: ClassVar[bool] = False
    conserving: ClassVar[bool] = True
    fresnel_parameters: ClassVar[tuple[str, ...]] = ()
    azimuths: ClassVar[tuple[float, ...]] = ()

    @abc.abstractmethod
    def f(self, wo: Array, wi: Array) -> Array:
        """The radiance BSDF in 1/sr, without the cosine.

        Args: unit vectors of shape (3,) in the local frame, z along the normal, both pointing away from
        the surface; wo.z > 0; wi.z < 0 for transmission. Returns a scalar. Must be pure JAX.
        """

    @property
    def value_levels(self) -> tuple[int, ...]:
        """Evaluations that a value of f takes at each level of `value`: 1 where f is a formula."""
        return (1,)

    def value(self, wo: Array, wi: Array, level: int) -> Estimate:
        """f with an error estimate, by the rule of one level (static): for models whose f is an integral."""
        value = self.f(wo, wi)
        return Estimate(value, jnp.zeros_like(value))

    def measure(self) -> Measure:
        """How to integrate f: by default over the hemisphere; override it where there is a better way."""
        return Hemisphere(self.f, self.transmissive, self.edges, self.azimuths)

    def edges(self, mu: Array) -> Array:
        """Cosines wi.z at which f(wo, .) jumps or bends for wo.z = mu, on all azimuths: none by default.

        The general rule puts the ends of its panels there; negative ones are on the other side. Returns an
        array of fixed length; a cosine outside [-1, 1] counts as none.
        """
        return jnp.zeros(0)

    def relative_ior(self) -> Array:
        """n_transmitted / n_incident as seen by wo: scales the transmitted lobe in energy transport."""
        return jnp.asarray(1.0)

    def albedo_kinks(self) -> Array:
        """Cosines mu in (0, 1] near which the albedo E(mu) may turn sharply: none by default.

        Averages over mu put the ends of their panels there. Returns an array of fixed length.
        """
        return jnp.zeros(0)

    def exact_albedo(self, mu: Array) -> Array | None:
        """The directional albedo in closed form, where there is one: an oracle for tests."""
        return None

    def exact_average(self) -> Array | None:
        """The average albedo in closed form, where there is one: an oracle for tests."""
        return None

    def per_bounce(self) -> "tuple[BSDF, Array] | None":
        """The same surface made white, and the mean reflectance of one bounce on it, where it has them.

        What series of multiple bounces are made of: F_avg of a microfacet conductor, rho of diffuse facets.
        """
        return None

    def active_parameters(self) -> tuple[str, ...]:
        """Names of the parameters that matter under the chosen options."""
        return tuple(self.parameter_ranges())

    def __check_init__(self) -> None:
        for name, choices in self.option_choices().items():
            value = getattr(self, name)
            if value not in choices:
                raise unknown(name, value, choices)

    @classmethod
    def parameter_ranges(cls) -> dict[str, tuple[float, float]]:
        """Name -> (low, high) of every field made by `ecfit.parameter`."""
        return {f.name: f.metadata["range"] for f in dataclasses.fields(cls) if "range" in f.metadata}

    @classmethod
    def option_choices(cls) -> dict[str, tuple[str, ...]]:
        """Name -> allowed values of every field made by `ecfit.option`."""
        return {f.name: f.metadata["choices"] for f in dataclasses.fields(cls) if "choices" in f.metadata}

    def options(self) -> dict[str, str]:
        """The chosen options."""
        return {name: getattr(self, name) for name in self.option_choices()}

    def parameter_value(self, name: str) -> Array:
        """The value of a parameter."""
        return getattr(self, name)

    def with_parameters(self, values: Mapping[str, Array]) -> "BSDF":
        """A copy with other parameters; scalars, arrays or tracers.

        Ranges are not checked (see `check_range`). Raises `EcfitError` for a name that is no parameter.
        """
        known = self.parameter_ranges()
        for name in values:
            if name not in known:
                raise unknown("parameter", name, known)
        names = list(values)
        if not names:
            return self
        return eqx.tree_at(
            lambda m: [getattr(m, n) for n in names], self, [_as_float64(values[n]) for n in names]
        )

    def check_range(self, name: str, low: float, high: float) -> None:
        """Raise `EcfitError` unless [low, high] lies in the range of the parameter `name`."""
        lowest, highest = self.parameter_ranges()[name]
        if not (lowest <= low and high <= highest):
            raise EcfitError(
                f"parameter '{name}' of {type(self).__name__} lies in [{lowest:g}, {highest:g}], "
                f"got [{low:g}, {high:g}]"
            )
