"""The interface between two media integrated over half vectors: what passes, and what is totally reflected.

Symbols as in `half_vector`; eta = n_transmitted / n_incident as seen by wo. Light passes where
x = wo.h > x_c = sqrt(1 - eta^2) (leaving the denser medium; x_c = 0 when entering it), and there
1 - F ~ sqrt(x - x_c). With theta_h outside and phi inside, every domain below is 0 < phi < phi_max(theta_h)
with one threshold X: cos(phi_max) = (X - mu cos theta_h) / (s sin theta_h). Its kinks, where phi_max leaves
0 or pi or X changes its formula, have closed forms; between them everything is analytic but for roots at
the ends, which clustered nodes remove.

With m = mu / cos(theta_h) and theta_c = acos(x_c):

- Transmission: the refracted ray is on the other side for x > x_c where m >= x_c, and for
  x > (m^2 + x_c^2) / (2 m) where m < x_c. Kinks for mu >= x_c: theta_h = theta_c - theta_o and
  theta_c + theta_o; for mu < x_c: tan(theta_h) = (s - eta) / mu, where the domain begins, m = x_c, and
  theta_c + theta_o.
- Reflection is the integral with F = 1 less that of 1 - F over x > x_c above the horizon of wi, x > m / 2.
  Kinks: |theta_c - theta_o|, theta_c + theta_o, |pi/4 -+ theta_o/2|, m = 2 x_c.
"""

from collections.abc import Callable
from typing import ClassVar, NamedTuple

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDF, Fresnel, UnitFresnel, masking_shadowing
from ecfit.quadrature.half_vector import HalfVectorReflection, direction
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import Estimate, graded, integrate

Array = jax.Array


# Near the normal two kinks meet, and the errors of the pieces' derivatives, which cancel in the value, are
# divided by s in that with respect to mu: wo is kept this far off the normal.
_OFF_NORMAL = 1e-9


class _View(NamedTuple):
    """wo and the critical angle: mu, s = sin(theta_o), x_c = cos(theta_c), y_c = sin(theta_c)."""

    mu: Array
    s: Array
    xc: Array
    yc: Array


def _root(v: Array) -> Array:
    """sqrt(max(v, 0)), with derivative 0 for v <= 0."""
    return jnp.where(v > 0.0, jnp.sqrt(jnp.where(v > 0.0, v, 1.0)), 0.0)


def _clustered(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A map of [0, 1] to itself with double root at 0 and triple at 1, and its derivative.

    Roots at either end of a piece become smooth; at small alpha the upper end also holds a layer of
    width alpha, for which 3 was better than 2 and 4 in both error and estimate (16 to 40 nodes).
    """
    v = 1.0 - u
    return 1.0 - v**3 * (1.0 + 3.0 * u), 12.0 * u * v * v


class Interface(Measure):
    """Both lobes of a rough interface, F reflected and 1 - F refracted, for mu and alpha in [0, 1].

    Attributes:
        ndf, masking, alpha: as for `HalfVectorReflection`.
        eta: n_transmitted / n_incident as seen by wo.
        fresnel: F(x), which is 1 for x < x_c.
        leaving: whether eta is 1 or less; else it is 1 or more.
    """

    ndf: NDF
    masking: str = eqx.field(static=True)
    alpha: Array
    eta: Array
    fresnel: Fresnel
    leaving: bool = eqx.field(static=True)

    default_level: ClassVar[int] = 1
    # The kinks are all known: nothing hides between the nodes.
    confirm: ClassVar[bool] = False
    # (nodes in slope on each piece, nodes in azimuth) of each level.
    ORDERS: ClassVar[tuple[tuple[int, int], ...]] = ((24, 16), (32, 22), (48, 32), (72, 48), (104, 80))
    # Least error estimate of each level, for the reason given for `HalfVectorReflection.FLOORS`.
    FLOORS: ClassVar[tuple[float, ...]] = (2e-9, 1e-9, 2e-10, 1e-10, 1e-10)
    # The same when entering: for mu < 3e-3 the true error of level 0 exceeded its estimate by 2e-7 at 4 of
    # 4000 random points.
    ENTERING_FLOOR: ClassVar[float] = 5e-7

    @property
    def levels(self) -> tuple[int, ...]:
        pieces = 5 if self.leaving else 2
        whole = HalfVectorReflection.ORDERS
        return tuple(a * b * pieces + c * d for (a, b), (c, d) in zip(self.ORDERS, whole, strict=True))

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        parts = []
        if lobe != "transmission":
            parts.append(self._reflected(mu, level))
        if lobe != "reflection":
            # The radiance BSDF: compressed by eta^2 into the other medium.
            parts.append(jax.tree.map(lambda v: v / (self.eta * self.eta), self._transmitted(mu, level)))
        return jax.tree.map(lambda *part: sum(part), *parts)

    def _view(self, mu: Array) -> _View:
        mu, s = direction(mu - _OFF_NORMAL * mu**1024)
        if not self.leaving:
            return _View(mu, s, jnp.zeros_like(self.eta), jnp.ones_like(self.eta))
        eta = jnp.minimum(self.eta, 1.0)
        return _View(mu, s, _root((1.0 - eta) * (1.0 + eta)), eta)

    def _reflected(self, mu: Array, level: int) -> Estimate:
        fresnel = UnitFresnel() if self.leaving else self.fresnel
        whole = HalfVectorReflection(self.ndf, self.masking, self.alpha, fresnel).albedo(mu, level, "all")
        if not self.leaving:
            return whole
        passed = self._passed(mu, level)
        return Estimate(whole.value - passed.value, whole.error + passed.error)

    def _transmitted(self, mu: Array, level: int) -> Estimate:
        """Mean of (1 - F) G2 / G1(wo) over the normals visible from wo."""
        view = self._view(mu)
        mu, s, xc, yc = view
        inside = mu >= xc
        # Each kink as a coordinate w of the slope tan(theta_h).
        begin = self._at(jnp.where(inside, 0.0, s - yc), mu)
        middle = jnp.where(
            inside,
            self._at(yc * mu - xc * s, mu * xc + s * yc),
            self._at(_root((xc - mu) * (xc + mu)), mu),
        )
        end = self._at(s * xc + yc * mu, mu * xc - s * yc)

        def threshold(m: Array) -> Array:
            return jnp.where(m < xc, 0.5 * (m + xc * xc / m), xc) if self.leaving else jnp.zeros_like(m)

        def mu_i(x: Array, cos_h: Array) -> Array:
            # eta cos(theta_t), from which the refracted ray's cosine follows.
            g = _root((self.eta - 1.0) * (self.eta + 1.0) + x * x)
            return (mu + (g - x) * cos_h) / self.eta

        return self._integral(view, [begin, middle, end], threshold, mu_i, level, opposite=True)

    def _passed(self, mu: Array, level: int) -> Estimate:
        """What the reflection lobe lacks of total reflection."""
        view = self._view(mu)
        mu, s, xc, yc = view
        inside = mu >= xc
        begin = self._at(jnp.where(inside, 0.0, s * xc - mu * yc), mu * xc + s * yc)
        # The domain is the whole circle in phi up to the first of these.
        edge = jnp.where(inside, self._at(yc * mu - xc * s, mu * xc + s * yc), 0.0)
        full = jnp.minimum(edge, self._at(mu, 1.0 + s))
        switch = self._at(_root((2.0 * xc - mu) * (2.0 * xc + mu)), mu)
        end = jnp.minimum(self._at(s * xc + yc * mu, mu * xc - s * yc), self._at(1.0 + s, mu))
        begin = jnp.minimum(begin, end)
        full, switch = jnp.clip(full, begin, end), jnp.clip(switch, begin, end)
        kinks = [begin, jnp.minimum(full, switch), jnp.maximum(full, switch), end]

        def threshold(m: Array) -> Array:
            return jnp.maximum(xc, 0.5 * m)

        def mu_i(x: Array, cos_h: Array) -> Array:
            return 2.0 * x * cos_h - mu

        return self._integral(view, kinks, threshold, mu_i, level, opposite=False)

    def _at(self, num: Array, den: Array) -> Array:
        """The NDF's coordinate of tan(theta_h) = num / den (negative: infinity for den, 0 for num)."""
        return self.ndf.chart(jnp.maximum(num, 0.0), self.alpha * jnp.maximum(den, 0.0))

    def _integral(
        self,
        view: _View,
        kinks: list[Array],
        threshold: Callable[[Array], Array],
        mu_i: Callable[[Array, Array], Array],
        level: int,
        *,
        opposite: bool,
    ) -> Estimate:
        """The integral of (1 - F) G2 / G1(wo) over visible normals with x > threshold(mu / cos(theta_h)).

        `kinks` are increasing; between the first and the last lies the domain. `mu_i` is |wi.z| by x and
        cos(theta_h).
        """
        slope, azimuth = (graded(0, count) for count in self.ORDERS[level])
        mu, s = view.mu, view.s
        # Shapes below: (slope, azimuth), pieces one after the other.
        low = jnp.stack(kinks[:-1])[:, None]
        width = jnp.maximum(jnp.stack(kinks[1:])[:, None] - low, 0.0)
        unit, dunit = _clustered(slope.nodes)
        w, dw = (low + width * unit).ravel()[:, None], (width * dunit).ravel()[:, None]
        n, d, density = self.ndf.nodes(w)
        n = self.alpha * n
        square = d * d + n * n
        length = jnp.sqrt(jnp.where(square > 0.0, square, 1.0))  # 0: the end of an empty piece at alpha = 0
        cos_h = d / length
        centre, swing = mu * cos_h, s * n / length  # x = centre + swing cos(phi)
        level_x = threshold(mu / jnp.where(cos_h > 0.0, cos_h, 1.0))
        phi_max = 2.0 * jnp.arctan2(
            jnp.sqrt(jnp.maximum(swing + centre - level_x, 1e-300)),
            jnp.sqrt(jnp.maximum(swing - centre + level_x, 1e-300)),
        )
        # t = tan(phi / 4): rational functions in place of a cosine for every node.
        t_max = jnp.tan(0.25 * phi_max)
        # 1 - F has a root at phi_max where there is total reflection.
        v = 1.0 - azimuth.nodes
        u, du = (1.0 - v * v, 2.0 * v) if self.leaving else (azimuth.nodes, np.ones_like(v))
        t = t_max * u
        q = 1.0 / (1.0 + t * t)
        half = (1.0 - t) * (1.0 + t) * q  # cos(phi / 2)
        cos_phi = 2.0 * half * half - 1.0
        x = jnp.clip(centre + swing * cos_phi, 0.0, 1.0)
        lit = jnp.maximum(mu_i(x, cos_h), 0.0)
        g = masking_shadowing(self.ndf, self.masking, mu, lit, self.alpha, opposite=opposite) * lit
        p = mu * d + s * n * cos_phi  # x length
        found = integrate(
            (8.0 * density * dw * t_max) * (du * q * p * g * (1.0 - self.fresnel(x))), slope, azimuth
        )
        floor = self.FLOORS[level] if level or self.leaving else self.ENTERING_FLOOR
        # What keeping off the normal changes, for a slope of up to 2 (0.6 was the largest seen).
        shift = jax.lax.stop_gradient(2.0 * _OFF_NORMAL * mu**1024)
        return Estimate(found.value, jnp.maximum(found.error, floor) + shift)
