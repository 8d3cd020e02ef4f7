"""Integrals over the normals of facets that two directions see both (Gotanda 2014, eq. 4).

I(wo, wi) = integral of (m.wo)+ (m.wi)+ D(m) w(m.wo, m.wi) over normals m. In polar angles of m about the
surface normal, with tan(theta) = alpha T:

- the NDF's own rule in T removes the peak of D for every alpha;
- for a fixed azimuth the facets that see a direction of cosine mu and sine s end in closed form at
  tan(theta) = mu / (-s cos), with cos of the azimuth between them; where cos >= 0 they end at the horizon.
  The nearer of the two ends bounds the slope, so that no kink is inside;
- that bound itself bends at six azimuths: a quarter turn to both sides of each direction, and on the axis on
  which the two great circles meet. They are break points, and a sinh map spreads the layer at each of them.
"""

from collections.abc import Callable
from typing import ClassVar

import equinox as eqx

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDF
from ecfit.quadrature.half_vector import direction
from ecfit.quadrature.rules import Estimate, graded, integrate

Array = jax.Array

# Least scale of the sinh maps: layers below it hold less than the rounding of the integral.
_LEAST_SCALE = 1e-9
# Nodes cluster with this power where the slope ends: grazing facets of a smooth surface are a thin layer
# there (of 1, 2, 3, 4 the best over random points with 12 to 32 nodes).
_POWER = 3


class FacetPairs(eqx.Module):
    """The rule for integrals of (m.wo)+ (m.wi)+ D(m) w(m.wo, m.wi), alpha in [0, 1], both ends included.

    Attributes:
        ndf: distribution of normals.
        alpha: its width.
        weight: w, of the cosines m.wo and m.wi in [0, 1].
    """

    ndf: NDF
    alpha: Array
    weight: Callable[[Array, Array], Array]

    # (nodes in slope, nodes in azimuth of each of the 12 half pieces) of each level.
    ORDERS: ClassVar[tuple[tuple[int, int], ...]] = ((12, 8), (20, 12), (32, 18), (48, 28), (80, 44))

    @property
    def levels(self) -> tuple[int, ...]:
        """Number of nodes of each level."""
        return tuple(12 * a * b for a, b in self.ORDERS)

    def integral(self, mu_o: Array, mu_i: Array, cos_phi: Array, level: int) -> Estimate:
        """I with an error estimate, by the rule of `level` (static).

        Args: cosines mu_o, mu_i in [0, 1], and cos_phi in [-1, 1] of the azimuth between wo and wi; scalars.
        """
        slope, azimuth = (graded(0, count) for count in self.ORDERS[level])
        (mu_o, s_o), (mu_i, s_i) = direction(mu_o), direction(mu_i)
        phi = jnp.arccos(jnp.clip(cos_phi, -1.0, 1.0))
        angle, jacobian = self._azimuths(mu_o, s_o, mu_i, s_i, phi, jnp.asarray(azimuth.nodes))
        c_o, c_i = s_o * jnp.cos(angle), s_i * jnp.cos(angle - phi)
        # Shapes below: (azimuth, slope).
        w_max = jnp.minimum(self._end(mu_o, c_o), self._end(mu_i, c_i))[:, None]
        v = 1.0 - slope.nodes
        n, d, density = self.ndf.nodes(w_max * (1.0 - v**_POWER))
        n = self.alpha * n
        square = d * d + n * n
        length = jnp.sqrt(jnp.where(square > 0.0, square, 1.0))
        p_o = jnp.maximum(mu_o * d + c_o[:, None] * n, 0.0)
        p_i = jnp.maximum(mu_i * d + c_i[:, None] * n, 0.0)
        x_o, x_i = jnp.minimum(p_o / length, 1.0), jnp.minimum(p_i / length, 1.0)
        # (m.wo) (m.wi) / cos(theta_m) d, where d cancels the cosine's.
        values = p_o * p_i / length * self.weight(x_o, x_i)
        weights = density * w_max * (_POWER * v ** (_POWER - 1))
        return integrate(jacobian[:, None] * (values * weights), azimuth, slope)

    def _end(self, mu: Array, c: Array) -> Array:
        """The NDF's coordinate of the slope at which facets turn away; c = s cos(azimuth)."""
        return self.ndf.chart(mu, self.alpha * jnp.maximum(-c, 0.0))

    @staticmethod
    def _azimuths(
        mu_o: Array, s_o: Array, mu_i: Array, s_i: Array, phi: Array, t: Array
    ) -> tuple[Array, Array]:
        """Azimuths from wo's and their Jacobians: nodes t of [0, 1] on each of 12 half pieces in turn."""
        quarter = 0.5 * jnp.pi
        meeting = jnp.arctan2(mu_i * s_o - mu_o * s_i * jnp.cos(phi), s_i * mu_o * jnp.sin(phi))
        zero = jnp.zeros_like(phi)
        ends = jnp.stack(
            [zero + quarter, zero - quarter, phi + quarter, phi - quarter, meeting, meeting + jnp.pi]
        )
        ends = jnp.sort(jnp.mod(ends, 2.0 * jnp.pi))
        # How far from the turning of either direction an end is: there lie the layer's singularities.
        scale = jnp.minimum(jnp.hypot(jnp.cos(ends), mu_o), jnp.hypot(jnp.cos(ends - phi), mu_i))
        scale = jnp.maximum(scale, _LEAST_SCALE)
        half = 0.5 * jnp.diff(jnp.append(ends, ends[0] + 2.0 * jnp.pi))
        start = jnp.concatenate([ends, jnp.roll(ends, -1)])[:, None]
        sign = jnp.repeat(jnp.array([1.0, -1.0]), ends.size)[:, None]
        scale = jnp.concatenate([scale, jnp.roll(scale, -1)])[:, None]
        width = jnp.concatenate([half, half])[:, None]
        # width sinh(a t) / sinh(a): the scale is reached at t ~ 1 / a.
        a = jnp.maximum(jnp.arcsinh(width / scale), 1e-3)
        angle = start + sign * width * jnp.sinh(a * t) / jnp.sinh(a)
        return angle.ravel(), (width * a * jnp.cosh(a * t) / jnp.sinh(a)).ravel()
