"""The base under the specular layer: a diffuse lobe of what the layer leaves, times a sheen."""

from typing import ClassVar

from ecfit._jax import jax, jnp
from ecfit.bsdf.sheen import inverted_gaussian
from ecfit.enterprise.energies import Albedos, remaining, specular_rule
from ecfit.enterprise.lobes import Lobe
from ecfit.microfacet import UnitFresnel
from ecfit.quadrature import Estimate
from ecfit.quadrature.rules import graded, integrate

Array = jax.Array


class Base(Lobe):
    """B = pi B_diffuse B_sheen (Enterprise PBR 2019x, Dielectric BSDF for Opaque Surfaces), without rho.

    pi B_diffuse = 1 - s + s (1 - E(v)) (1 - E(l)) / (1 - E_avg), the second term 0 for directions that are
    totally reflected; B_sheen = b^ / pi + (1 - b^) M_b with b^ = (1 - b)^5.

    Attributes:
        albedos: where E and E_avg come from.
        s: amount of specular.
        b: sheen.
        critical: cosine below which a direction is totally reflected, 0 seen from outside.
    """

    albedos: Albedos
    s: Array
    b: Array
    critical: Array

    confirm: ClassVar[bool] = True
    # Nodes on each of the two panels of a piece in sqrt(mu_i), and in azimuth.
    ORDERS: ClassVar[tuple[int, ...]] = (12, 16, 24, 40, 64)
    _PIECES: ClassVar[int] = 2
    _DEPTH: ClassVar[int] = 1

    @property
    def levels(self) -> tuple[int, ...]:
        panels = 1 + self._DEPTH
        rule = specular_rule(self.albedos.alpha, UnitFresnel()).levels
        polar = [self._PIECES * panels * n for n in self.ORDERS]
        exact = self.albedos.integrals
        return tuple(p * (panels * n + exact * m) for p, n, m in zip(polar, self.ORDERS, rule, strict=True))

    @property
    def _plain(self) -> Array:
        return (1.0 - self.b) ** 5

    def _allowed(self, mu: Array) -> Array:
        return jnp.where(mu >= self.critical, 1.0, 0.0)

    def _diffuse(self, mu_o: Array, mu_i: Array, level: int) -> Array:
        """pi B_diffuse; mu_i of any shape."""
        rest, lost = remaining(self.albedos.base_average(level).value)
        o = self.albedos.base(mu_o, level).value
        i = jax.vmap(lambda m: self.albedos.base(m, level).value)(mu_i.ravel()).reshape(mu_i.shape)
        both = self._allowed(mu_o) * self._allowed(mu_i) * lost
        return 1.0 - self.s + self.s * both * (1.0 - o) * (1.0 - i) / rest

    def f(self, wo: Array, wi: Array) -> Array:
        above = (wo[2] > 0.0) & (wi[2] > 0.0)
        wi = jnp.where(above, wi, jnp.array([0.0, 0.0, 1.0]))
        wo = jnp.where(above, wo, jnp.array([0.0, 0.0, 1.0]))
        sheen = self._plain / jnp.pi + (1.0 - self._plain) * inverted_gaussian(self.b, wo, wi)
        return jnp.where(above, self._diffuse(wo[2], wi[2], self.default_level) * sheen, 0.0)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return Estimate(jnp.zeros_like(mu), jnp.zeros_like(mu))
        rule = graded(self._DEPTH, self.ORDERS[level])
        x, width = jnp.asarray(rule.nodes), jnp.asarray(rule.widths)
        mu = jnp.clip(mu, 1e-12, 1.0)
        # Pieces on both sides of the critical cosine; nodes cluster at grazing, where E turns.
        edge = jnp.sqrt(self.critical)
        t = jnp.concatenate([edge * x, edge + (1.0 - edge) * x])
        dt = jnp.concatenate([edge * width, (1.0 - edge) * width])
        mu_i = jnp.clip(t * t, 1e-14, 1.0)
        polar = self._diffuse(mu, mu_i, level) * mu_i * 2.0 * t * dt
        s_o, s_i = jnp.sqrt((1.0 - mu) * (1.0 + mu)), jnp.sqrt((1.0 - mu_i) * (1.0 + mu_i))
        phi, dphi = jnp.pi * x, 2.0 * jnp.pi * width
        wo = jnp.stack([s_o, jnp.zeros_like(mu), mu])

        def sheen(sin: Array, cos: Array, angle: Array) -> Array:
            wi = jnp.stack([sin * jnp.cos(angle), sin * jnp.sin(angle), cos])
            return inverted_gaussian(self.b, wo, wi)

        lobes = jax.vmap(jax.vmap(sheen, (None, None, 0)), (0, 0, None))(s_i, mu_i, phi)
        values = self._plain / jnp.pi + (1.0 - self._plain) * lobes
        return integrate(polar[:, None] * values * dphi, rule, rule)
