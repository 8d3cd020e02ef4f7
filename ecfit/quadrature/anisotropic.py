"""The anisotropic GGX lobe integrated over half vectors, for one azimuth of wo or the mean over all.

At the azimuth phi of h, anisotropic GGX is the isotropic one of width k(phi),
1 / k^2 = cos^2(phi) / alpha_u^2 + sin^2(phi) / alpha_v^2, times k^2 / (alpha_u alpha_v): the polar integral
of `HalfVectorReflection` holds unchanged, with its horizon in closed form. What differs is the azimuth:
there is no mirror symmetry, and k turns within min / max of the widths. The angle psi,
tan(phi) = (alpha_v / alpha_u) tan(psi), in which normals are uniform, spreads that.
"""

from typing import ClassVar

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.microfacet import GGX, Fresnel
from ecfit.quadrature.half_vector import direction, horizon
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import Estimate, graded, integrate

Array = jax.Array

_NDF = GGX()


def stretched(alpha_u: Array, alpha_v: Array, w: tuple[Array, Array, Array]) -> Array:
    """sqrt(alpha_u^2 w_x^2 + alpha_v^2 w_y^2 + w_z^2) = (1 + 2 Lambda(w)) w_z (Heitz 2014, eq. 85)."""
    square = (alpha_u * w[0]) ** 2 + (alpha_v * w[1]) ** 2 + w[2] ** 2
    return jnp.where(square > 0.0, jnp.sqrt(jnp.where(square > 0.0, square, 1.0)), 0.0)


class AnisotropicReflection(Measure):
    """f = F D G2 / (4 mu_o mu_i) of anisotropic GGX with height-correlated Smith.

    Attributes:
        alpha_u, alpha_v: widths along x and y, in (0, 1].
        phi: azimuth of wo, from x.
        fresnel: F(wo.h).
        azimuths: azimuths of wo over a quarter turn that are averaged (0: that of phi alone).
    """

    alpha_u: Array
    alpha_v: Array
    phi: Array
    fresnel: Fresnel
    azimuths: int = eqx.field(static=True, default=0)

    default_level: ClassVar[int] = 2
    confirm: ClassVar[bool] = True
    # (panels of the azimuth of h, its nodes on each, nodes in slope) of each level.
    ORDERS: ClassVar[tuple[tuple[int, int, int], ...]] = (
        (8, 10, 24),
        (8, 16, 32),
        (8, 24, 44),
        (8, 40, 64),
        (8, 72, 96),
    )

    @property
    def levels(self) -> tuple[int, ...]:
        return tuple(max(self.azimuths, 1) * p * a * s for p, a, s in self.ORDERS)

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        if lobe == "transmission":
            return Estimate(jnp.zeros_like(mu), jnp.zeros_like(mu))
        if not self.azimuths:
            return self._at(mu, self.phi, level)
        # E is even and has the period pi in phi: the midpoint rule converges geometrically.
        phi = 0.5 * jnp.pi * (np.arange(self.azimuths) + 0.5) / self.azimuths
        found = jax.vmap(lambda p: self._at(mu, p, level))(phi)
        return Estimate(jnp.mean(found.value), jnp.mean(found.error))

    def _azimuths(self, mu: Array, phi_o: Array, level: int) -> tuple[Array, Array, Array]:
        """cos and sin of the azimuth of h, from x, and the weight dphi of each node."""
        _, count, _ = self.ORDERS[level]
        rule = graded(0, count)
        x, width = jnp.asarray(rule.nodes), jnp.asarray(rule.widths)
        # The horizon turns within mu of the two directions at right angles to wo, in psi as well half a turn
        # apart. Panels end there, and a sinh map clusters their nodes.
        across = jnp.arctan2(self.alpha_u * jnp.cos(phi_o), -self.alpha_v * jnp.sin(phi_o))
        psi, dpsi = [], []
        for turn in range(2):
            for half in (-1.0, 1.0):
                scale = jnp.maximum(mu, 1e-3)
                b_max = jnp.arcsinh(0.5 * jnp.pi / scale)
                for piece in (0.0, 0.5):
                    b = b_max * (piece + 0.5 * x)
                    psi.append(across + turn * jnp.pi + half * scale * jnp.sinh(b))
                    dpsi.append(0.5 * b_max * scale * jnp.cosh(b) * width)
        angle, weight = jnp.concatenate(psi), jnp.concatenate(dpsi)
        # phi of psi, and dphi = (alpha_u alpha_v / k^2) dpsi, whose factor D has the inverse of.
        cx, cy = self.alpha_u * jnp.cos(angle), self.alpha_v * jnp.sin(angle)
        length = jnp.sqrt(cx * cx + cy * cy)
        return cx / length, cy / length, weight

    def _at(self, mu: Array, phi_o: Array, level: int) -> Estimate:
        au, av = self.alpha_u, self.alpha_v
        mu, s = direction(mu)
        ox, oy = s * jnp.cos(phi_o), s * jnp.sin(phi_o)
        cos_h, sin_h, weight = self._azimuths(mu, phi_o, level)
        k = 1.0 / jnp.sqrt((cos_h / au) ** 2 + (sin_h / av) ** 2)
        along = cos_h * jnp.cos(phi_o) + sin_h * jnp.sin(phi_o)
        num, den = horizon(mu, s, along)
        rule = graded(0, self.ORDERS[level][2])
        power, v = _NDF.horizon_power, 1.0 - rule.nodes
        w_max = _NDF.chart(num, k * den)[:, None]
        n, d, density = _NDF.nodes(w_max * (1.0 - v**power))
        w = density * w_max * (power * v ** (power - 1))
        n = k[:, None] * n
        r2 = d * d + n * n
        p = d * mu + n * (s * along)[:, None]  # x R
        mu_i = jnp.maximum(2.0 * p * d / r2 - mu, 0.0)
        wi = (2.0 * p * n * cos_h[:, None] / r2 - ox, 2.0 * p * n * sin_h[:, None] / r2 - oy, mu_i)
        # G2 / mu_o with G2 = 2 / (stretched(wo) / mu_o + stretched(wi) / mu_i).
        below = mu_i * stretched(au, av, (ox, oy, mu)) + mu * stretched(au, av, wi)
        g = jnp.where(below > 0.0, 2.0 * mu_i / jnp.where(below > 0.0, below, 1.0), 0.0)
        x = jnp.minimum(p / jnp.sqrt(r2), 1.0)
        line = graded(0, self.ORDERS[level][1])
        return integrate(weight[:, None] * (self.fresnel(x) * g * p * w), line, rule)
