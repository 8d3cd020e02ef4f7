"""Integrals of albedos over the cosine of the view: averages and moments."""

from collections.abc import Callable
from typing import NamedTuple

from ecfit._jax import jax, jnp
from ecfit.quadrature.rules import Estimate, Rule, graded, integrate_line

Array = jax.Array


def cosine_count(level: int) -> int:
    """Nodes of an integral over mu, between two kinks, at a level of a measure."""
    return 8 + 6 * level


class CosineRule(NamedTuple):
    """Nodes over mu in [0, 1], closer where an albedo changes fast.

    Attributes:
        rule: the panels.
        mu: cosines, shape (nodes,); slope: d mu of each in the rule's own variable; weights: of the rule.
    """

    rule: Rule
    mu: Array
    slope: Array
    weights: Array

    @classmethod
    def between(cls, count: int, kinks: Array | None = None) -> "CosineRule":
        """`count` nodes between two neighbours of 0, `kinks` (cosines in (0, 1), any order) and 1."""
        rule = graded(0, count)
        kinks = jnp.zeros(0) if kinks is None else jnp.sort(kinks)
        # E changes fastest within mu ~ alpha of grazing and of its kinks: nodes cluster there with t^2.
        t = jnp.asarray(rule.nodes)
        ends = jnp.concatenate([jnp.zeros(1), kinks, jnp.ones(1)])
        low, width = ends[:-1, None], jnp.diff(ends)[:, None]
        unit, slope = (t * t, 2.0 * t) if kinks.size == 0 else (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t))
        weights = jnp.tile(jnp.asarray(rule.weights), ends.size - 1)
        return cls(rule, (low + width * unit).ravel(), (width * slope).ravel(), weights)

    def integral(
        self, albedo: Callable[[Array], Estimate], weight: Array, of: Callable[[Array], Array] = jnp.asarray
    ) -> Estimate:
        """Integral of weight x of(albedo(mu)) dmu, with the error of the rule and of the albedos.

        Args:
            albedo: at one cosine.
            weight: at the cosines `mu`.
            of: something linear in the albedo with slope 1 or -1.
        """
        found = jax.vmap(albedo)(self.mu)
        weight = weight * self.slope
        line = integrate_line(weight * of(found.value), self.rule)
        return Estimate(line.value, line.error + self.weights @ (jnp.abs(weight) * found.error))

    def average(self, albedo: Callable[[Array], Estimate]) -> Estimate:
        """2 x integral of E(mu) mu dmu (Sforza & Pellacini 2022, eq. 5)."""
        return self.integral(albedo, 2.0 * self.mu)
