"""Where the Enterprise PBR model takes its albedos from: the integral, the printed fits, tables, our fits.

Everything the model compensates with is a function of the GGX width and of F0: the albedo E_m of the white
single-scattering lobe, that of the layer over a diffuse base, E, and the averages of both. What a renderer
has in their place need not belong together (the printed E_avg is not the average of the printed E), so that
an average "as used" and the true mean of the directional albedo are kept apart: their ratio is what a
furnace shows.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.approximation import Approximation, lookup_table, published
from ecfit.compensation.formulas import kulla_conty_fresnel
from ecfit.enterprise.average import white_average
from ecfit.microfacet import NDFS, Fresnel, SchlickFresnel, UnitFresnel
from ecfit.quadrature import CosineRule, Estimate, HalfVectorReflection, cosine_count

Array = jax.Array

MASKING = "height-correlated"
ENERGIES = ("exact", "printed", "tables", "none")
ENERGY_DOC = "source of E_m, E and their averages: the integral, the printed fits, tables, no compensation"

# Absolute error of the entries of a table that is read with 16 or 32 nodes: far below what lies between them.
_TABLE_TOLERANCE = 1e-6
# Nodes of a mean of what costs nothing: enough for the kinks of a table.
_CHEAP = 128


@cache
def _printed(part: str) -> Approximation:
    """The document's fit of E_m ("single"), E ("base"), or the average of one ("single-average", ...)."""
    return published("enterprise-pbr-2019x" + part.removeprefix("single").replace("base", "-base"))


@cache
def _table(part: str) -> Approximation:
    """A table of the document's size, 32 x 32, 32, 16^3 or 16^2, ends included, linear between its nodes."""
    from ecfit.bsdf import model

    count, base = (16, True) if part.startswith("base") else (32, False)
    average = part.endswith("-average")
    names = (*(("F0",) if base else ()), "r", *(() if average else ("mu",)))
    quantity = "average-albedo" if average else "directional-albedo"

    def made() -> Approximation:
        bsdf = model("enterprise-metallic") if base else model("conductor", masking=MASKING)
        return lookup_table(bsdf, dict.fromkeys(names, count), quantity=quantity, tolerance=_TABLE_TOLERANCE)

    # The first use may be within the trace of a model's own integral: a thread of its own has no trace.
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(made).result()


_SOURCES = {"printed": _printed, "tables": _table}


def specular_rule(alpha: Array, fresnel: Fresnel) -> HalfVectorReflection:
    """The rule of the document's M_r F: GGX with height-correlated Smith."""
    return HalfVectorReflection(NDFS["ggx"], MASKING, alpha, fresnel)


def average_schlick(f0: Array, f90: Array) -> Array:
    """F_m,avg = F90 / 21 + 20 F0 / 21, exact for Schlick's factor."""
    return (f90 + 20.0 * f0) / 21.0


class Albedos(eqx.Module):
    """The four albedos at one roughness and one F0, from the chosen source.

    Attributes:
        alpha: GGX width.
        F0: of the layer over a base, F0 rho_s.
        energy: a name of `ENERGIES`.
    """

    alpha: Array
    F0: Array
    energy: str = eqx.field(static=True)

    @property
    def integrals(self) -> int:
        """Albedos of the microfacet lobe that one value takes, without its average."""
        return 2 if self.energy == "exact" else 0

    def single(self, mu: Array, level: int) -> Estimate:
        """E_m(mu)."""
        if self.energy == "exact":
            return specular_rule(self.alpha, UnitFresnel()).albedo(mu, level, "reflection")
        return self._given("single", jnp.ones_like(mu), mu)

    def single_average(self, level: int) -> Estimate:
        """E_m,avg as used."""
        if self.energy == "exact":
            return _known(white_average(self.alpha))
        return self._given("single-average", jnp.ones_like(self.alpha))

    def single_mean(self, level: int) -> Estimate:
        """The mean of `single`."""
        if self.energy == "exact":
            return self.single_average(level)
        return self._mean(self.single, level)

    def F_ms(self, f0: Array, f90: Array, level: int) -> Array:
        """F_avg^2 E_m,avg / (1 - F_avg (1 - E_m,avg)) (Energy Preservation, second factor)."""
        return kulla_conty_fresnel(average_schlick(f0, f90), self.single_average(level).value)

    def base(self, mu: Array, level: int) -> Estimate:
        """E(mu): the layer with its multiple scattering, F90 = 1."""
        if self.energy == "exact":
            one = jnp.asarray(1.0)
            direct = specular_rule(self.alpha, SchlickFresnel(self.F0, one)).albedo(mu, level, "reflection")
            single = self.single(mu, level)
            share = self.F_ms(self.F0, one, level)
            return Estimate(
                direct.value + (1.0 - single.value) * share, direct.error + jnp.abs(share) * single.error
            )
        return self._given("base", jnp.zeros_like(mu), mu)

    def base_average(self, level: int) -> Estimate:
        """E_avg as used."""
        if self.energy == "exact":
            return self.base_mean(level)
        return self._given("base-average", jnp.zeros_like(self.alpha))

    def base_mean(self, level: int) -> Estimate:
        """The mean of `base`."""
        return self._mean(self.base, level)

    def _mean(self, albedo: Callable[[Array, int], Estimate], level: int) -> Estimate:
        """The average of `single` or `base` over mu."""
        count = cosine_count(level) if self.energy == "exact" else _CHEAP
        return CosineRule.between(count).average(lambda mu: albedo(mu, level))

    def _given(self, part: str, none: Array, mu: Array | None = None) -> Estimate:
        """A part from the source; `none` where nothing is compensated."""
        if self.energy == "none":
            return _known(none)
        approximation = _SOURCES[self.energy](part)
        given = {"alpha": self.alpha}
        if "F0" in approximation.variables:
            given["F0"] = self.F0
        if mu is not None:
            given["mu"] = mu
        return _known(approximation(**given))


def _known(value: Array) -> Estimate:
    return Estimate(value, jnp.zeros_like(value))


def remaining(average: Array) -> tuple[Array, Array]:
    """(1 - average, 1) where that is positive, else (1, 0): what a lobe of lost energy is divided by."""
    lost = average < 1.0
    return jnp.where(lost, 1.0 - average, 1.0), jnp.where(lost, 1.0, 0.0)
