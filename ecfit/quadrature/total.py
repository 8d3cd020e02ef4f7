"""A weighted sum of lobes, each with the rule that suits it."""

from ecfit._jax import jax, jnp
from ecfit.quadrature.measure import Measure
from ecfit.quadrature.rules import Estimate

Array = jax.Array


class Total(Measure):
    """The sum of weight x measure; a part with fewer levels stays at its finest one.

    Attributes:
        parts: (weight, measure) pairs; the weights are scalars that do not depend on directions.
    """

    parts: tuple[tuple[Array, Measure], ...]

    @property
    def default_level(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        return max(measure.default_level for _, measure in self.parts)

    @property
    def confirm(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        return any(measure.confirm for _, measure in self.parts)

    @property
    def levels(self) -> tuple[int, ...]:
        all_ = [measure.levels for _, measure in self.parts]
        count = max(len(levels) for levels in all_)
        return tuple(sum(levels[min(i, len(levels) - 1)] for levels in all_) for i in range(count))

    def albedo(self, mu: Array, level: int, lobe: str) -> Estimate:
        value, error = jnp.zeros_like(mu), jnp.zeros_like(mu)
        for weight, measure in self.parts:
            found = measure.albedo(mu, min(level, len(measure.levels) - 1), lobe)
            value, error = value + weight * found.value, error + jnp.abs(weight) * found.error
        return Estimate(value, error)
