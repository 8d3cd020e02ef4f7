"""The linearly transformed cosine nearest to the lobe (1 - E) mu: one number for a model without azimuth."""

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.ltc.stretched import stretched_cosine
from ecfit.quadrature import Estimate
from ecfit.quadrature.rules import integrate_line
from ecfit.quantities.base import AverageAlbedo

Array = jax.Array

# Bounds of log a: from a lobe about the normal of 0.1 to one at grazing of 1 / 3000, which a conductor has at
# alpha = 1e-6. Sixty halvings reach the last digit.
_LOWEST, _HIGHEST, _HALVINGS = -2.3, 8.0, 60


class LtcScale(AverageAlbedo):
    """a of M = diag(a, a, 1) whose lobe is nearest to (1 - E(mu)) mu, least squares over directions.

    Both lobes are taken with the integral 1: the amplitude pi (1 - E_avg) is known. The first to be made for
    the lobe that the MSBRDF blog (Mayaux 2018 part 2) leaves open. Not a number where nothing is lost.
    """

    def bounded(self, model: BSDF) -> bool:
        return False

    def estimate(self, model: BSDF, mu: Array, level: int) -> Estimate:
        rule, cosine, slope, weights = self.rule(model, level)
        albedo = jax.vmap(lambda m: self.directional(model, m, level))(cosine)
        lost = 1.0 - albedo.value
        amplitude = 2.0 * jnp.pi * weights @ (lost * cosine * slope)
        lobe, doubt = lost * cosine / amplitude, albedo.error * cosine / jnp.abs(amplitude)

        def pull(log_scale: Array) -> tuple[Array, Array]:
            """Integrand of the squared distance's slope in log a, and what a change of the lobe adds."""
            value, turn = jax.jvp(
                lambda s: stretched_cosine(cosine, jnp.exp(s)), (log_scale,), (jnp.ones_like(log_scale),)
            )
            return (value - lobe) * turn * slope, turn * slope

        def halve(ends: tuple[Array, Array], _: None) -> tuple[tuple[Array, Array], None]:
            low, high = ends
            middle = 0.5 * (low + high)
            too_low = weights @ pull(middle)[0] < 0.0
            return (jnp.where(too_low, middle, low), jnp.where(too_low, high, middle)), None

        ends = jnp.asarray(_LOWEST), jnp.asarray(_HIGHEST)
        (low, high), _ = jax.lax.scan(halve, ends, None, length=_HALVINGS)
        found = jax.lax.stop_gradient(0.5 * (low + high))
        integrand, turn = pull(found)
        curvature = jax.jvp(lambda s: weights @ pull(s)[0], (found,), (jnp.ones_like(found),))[1]
        # One Newton step changes nothing but carries the derivatives.
        scale = jnp.exp(found - weights @ integrand / jax.lax.stop_gradient(curvature))
        wrong = integrate_line(integrand, rule).error + weights @ (jnp.abs(turn) * doubt)
        inside = (found > _LOWEST + 1e-6) & (found < _HIGHEST - 1e-6) & (amplitude > 1e-12)
        error = scale * wrong / jnp.abs(curvature)
        return Estimate(jnp.where(inside, scale, jnp.nan), jax.lax.stop_gradient(error))
