"""Ways to draw wi for a given view: a density and a sampler each."""

import abc
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.errors import unknown
from ecfit.sampling.coefficients import LobeForm, lobe_form
from ecfit.sampling.cosine import TransformedCosine

Array = jax.Array


class Technique(eqx.Module):
    """A density over wi for wo = (sin theta_o, 0, mu), and a sampler of it.

    `needs` is how many uniform numbers a sample takes.
    """

    needs: ClassVar[int] = 2

    @abc.abstractmethod
    def pdf(self, wi: Array, mu: Array, r: Array) -> Array:
        """Density per steradian at a unit vector of shape (3,); mu and r scalars."""

    @abc.abstractmethod
    def sample(self, u: Array, mu: Array, r: Array) -> Array:
        """A unit vector from uniform numbers of shape (needs,)."""

    def terminator(self, mu: Array, r: Array) -> tuple[Array, Array]:
        """(p, q): the density bends or vanishes where p wi.z = q wi.x; (1, 0) for no such plane."""
        return jnp.ones_like(mu), jnp.zeros_like(mu)


class Cosine(Technique):
    """Density mu_i / pi."""

    def pdf(self, wi: Array, mu: Array, r: Array) -> Array:
        return jnp.maximum(wi[2], 0.0) / jnp.pi

    def sample(self, u: Array, mu: Array, r: Array) -> Array:
        one, zero = jnp.asarray(1.0), jnp.asarray(0.0)
        return TransformedCosine(one, zero, one, zero, False).sample(u)


class Uniform(Technique):
    """Density 1 / (2 pi)."""

    def pdf(self, wi: Array, mu: Array, r: Array) -> Array:
        return jnp.where(wi[2] > 0.0, 0.5 / jnp.pi, 0.0)

    def sample(self, u: Array, mu: Array, r: Array) -> Array:
        s, phi = jnp.sqrt(jnp.maximum(1.0 - u[0] * u[0], 0.0)), 2.0 * jnp.pi * u[1]
        return jnp.stack([s * jnp.cos(phi), s * jnp.sin(phi), u[0]])


class Transformed(Technique):
    """A transformed cosine: whole ("LTC") or clipped to the upper hemisphere ("CLTC")."""

    form: LobeForm
    clipped: bool = eqx.field(static=True, default=True)

    def pdf(self, wi: Array, mu: Array, r: Array) -> Array:
        return self.form.matrix(mu, r, self.clipped).pdf(wi)

    def sample(self, u: Array, mu: Array, r: Array) -> Array:
        return self.form.matrix(mu, r, self.clipped).sample(u)

    def terminator(self, mu: Array, r: Array) -> tuple[Array, Array]:
        matrix = self.form.matrix(mu, r)
        return matrix.a, matrix.d


class Mixture(Technique):
    """A clipped transformed cosine, or with probability `share` a uniform direction; one-sample MIS."""

    lobe: TransformedCosine
    share: Array

    needs: ClassVar[int] = 3

    def pdf(self, wi: Array, mu: Array, r: Array) -> Array:
        return self.share * Uniform().pdf(wi, mu, r) + (1.0 - self.share) * self.lobe.pdf(wi)

    def sample(self, u: Array, mu: Array, r: Array) -> Array:
        even = Uniform().sample(u[:2], mu, r)
        return jnp.where(u[2] < self.share, even, self.lobe.sample(u[:2]))

    def terminator(self, mu: Array, r: Array) -> tuple[Array, Array]:
        return self.lobe.a, self.lobe.d


class Mixed(Technique):
    """The mixture whose lobe and share a form gives for mu and r."""

    form: LobeForm

    needs: ClassVar[int] = 3

    def mixture(self, mu: Array, r: Array) -> Mixture:
        """The mixture at scalars."""
        return Mixture(self.form.matrix(mu, r), self.form.uniform(mu, r))

    def pdf(self, wi: Array, mu: Array, r: Array) -> Array:
        return self.mixture(mu, r).pdf(wi, mu, r)

    def sample(self, u: Array, mu: Array, r: Array) -> Array:
        return self.mixture(mu, r).sample(u, mu, r)

    def terminator(self, mu: Array, r: Array) -> tuple[Array, Array]:
        return self.mixture(mu, r).terminator(mu, r)


TECHNIQUES = ("cosine", "uniform", "ltc", "cltc", "cltc+uniform")


def technique(name: str, form: LobeForm | str = "portsmouth-2024") -> Technique:
    """A technique by name (`TECHNIQUES`), with the numbers of a form where it has any.

    Raises `EcfitError` for an unknown name.
    """
    if name not in TECHNIQUES:
        raise unknown("technique", name, TECHNIQUES)
    if name in ("cosine", "uniform"):
        return Cosine() if name == "cosine" else Uniform()
    form = lobe_form(form) if isinstance(form, str) else form
    return Mixed(form) if name == "cltc+uniform" else Transformed(form, name == "cltc")
