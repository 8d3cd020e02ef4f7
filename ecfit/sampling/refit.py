"""The numbers of a lobe form fitted by the variance of its weights, against those of another.

First the best transformed cosine and share at each point by itself, then the form's numbers nearest to those,
then the numbers that make the variance of the form small over all points.
"""

from typing import Any

import equinox as eqx
import optimistix

from ecfit._jax import jax, jnp
from ecfit.bsdf import BSDF
from ecfit.sampling.coefficients import LobeForm
from ecfit.sampling.cosine import TransformedCosine
from ecfit.sampling.techniques import Mixed, Mixture
from ecfit.sampling.weights import moments

Array = jax.Array

# Gauss nodes a panel: the gradient needs fewer than the numbers that are reported.
_NODES = 8
# Squares of this power of the variance's ratio are added up: the worst point counts most. The ratio of the
# largest weight counts this much.
_POWER, _LARGEST = 8, 0.06


def _statistics(model: BSDF, technique: Any, mu: Array, r: Array, name: str) -> Array:
    """[variance, largest weight] at scalars mu and r."""
    mean, second, _, largest = moments(model.with_parameters({name: r}), technique, mu, r, nodes=_NODES)
    return jnp.stack([second - mean * mean, largest])


def _vector(form: LobeForm, mu: Array, r: Array) -> Array:
    """a, b, c, d and the share at scalars."""
    m = form.matrix(mu, r)
    return jnp.stack([m.a, m.b, m.c, m.d, form.uniform(mu, r)])


def best_lobes(
    model: BSDF, start: LobeForm, mu: Array, r: Array, name: str = "diffuse_roughness"
) -> tuple[Array, Array]:
    """a, b, c, d and share of least variance at each of flat points, shape (points, 5), and its ratio.

    The ratio is that of the variance to the variance of `start`; each point is fitted by itself, by BFGS. A
    largest weight beyond 1.1 times that of `start` is penalised.
    """

    def one(point: tuple[Array, Array]) -> tuple[Array, Array]:
        mu, r = point
        before = _statistics(model, Mixed(start), mu, r, name)
        first = _vector(start, mu, r)

        def technique(v: Array) -> Mixture:
            # Positive a and c, and a share in (0, 1), whatever the numbers.
            lobe = TransformedCosine(first[0] * jnp.exp(v[0]), v[1], first[2] * jnp.exp(v[2]), v[3])
            return Mixture(lobe, jax.nn.sigmoid(v[4]))

        def loss(v: Array, _: Any) -> Array:
            ratio = _statistics(model, technique(v), mu, r, name) / before
            return ratio[0] + jnp.maximum(ratio[1] - 1.1, 0.0) ** 2

        share = jnp.log(first[4] / (1.0 - first[4]))
        origin = jnp.stack([0.0 * mu, first[1], 0.0 * mu, first[3], share])
        found = optimistix.minimise(
            loss, optimistix.BFGS(rtol=1e-5, atol=1e-6), origin, max_steps=60, throw=False
        )
        made = technique(found.value)
        after = _statistics(model, made, mu, r, name)
        lobe = made.lobe
        return jnp.stack([lobe.a, lobe.b, lobe.c, lobe.d, made.share]), after[0] / before[0]

    return jax.jit(lambda *p: jax.lax.map(one, p, batch_size=32))(mu, r)


def nearest_form(lobes: Array, start: LobeForm, mu: Array, r: Array) -> LobeForm:
    """The form's numbers whose a, b, c, d and share are nearest to given ones, by Levenberg-Marquardt."""
    numbers, rest = eqx.partition(start, eqx.is_inexact_array)
    # Differences of entries per roughness, to which most of them are proportional; shares are small numbers.
    scale = jnp.stack([r, r, r, r, jnp.full_like(r, 0.1)], axis=1)

    def residual(numbers: LobeForm, _: Any) -> Array:
        found = jax.vmap(lambda m, k: _vector(eqx.combine(numbers, rest), m, k))(mu, r)
        return (found - lobes) / scale

    solver = optimistix.LevenbergMarquardt(rtol=1e-8, atol=1e-8)
    return eqx.combine(
        optimistix.least_squares(residual, solver, numbers, max_steps=400, throw=False).value, rest
    )


def refit_lobe(
    model: BSDF,
    start: LobeForm,
    mu: Any,
    r: Any,
    *,
    source: str = "",
    max_steps: int = 30,
    name: str = "diffuse_roughness",
) -> LobeForm:
    """The numbers of a form that make its variance small against that of `start`, most at the worst point.

    Args:
        model: the BSDF that is sampled, with the parameter `name`.
        start: numbers to begin from and to be compared with.
        mu, r: points of the fit, arrays that broadcast; r > 0.
        source: what the result says of itself.
        max_steps: of Levenberg-Marquardt, from either of two starts.
    """
    mu, r = (v.ravel() for v in jnp.broadcast_arrays(jnp.asarray(mu, float), jnp.asarray(r, float)))
    before = jax.jit(jax.vmap(lambda m, k: _statistics(model, Mixed(start), m, k, name)))(mu, r)

    def residual(numbers: LobeForm, rest: Any) -> Array:
        form = eqx.combine(numbers, rest)
        found = jax.vmap(lambda m, k: _statistics(model, Mixed(form), m, k, name))(mu, r)
        ratio = found / before
        # A share below 0 has no meaning.
        negative = jnp.maximum(1e-4 - jax.vmap(form.uniform)(mu, r), 0.0) * 1e3
        return jnp.concatenate([ratio[:, 0] ** _POWER, _LARGEST * ratio[:, 1] ** 6, negative])

    lobes, _ = best_lobes(model, start, mu, r, name)
    trials = []
    for first in (nearest_form(lobes, start, mu, r), start):
        numbers, rest = eqx.partition(first, eqx.is_inexact_array)
        made = optimistix.least_squares(
            residual,
            optimistix.LevenbergMarquardt(rtol=1e-6, atol=1e-7),
            numbers,
            rest,
            max_steps=max_steps,
            throw=False,
        ).value
        size = float(jnp.sum(eqx.filter_jit(residual)(made, rest) ** 2))
        trials.append((size if size == size else float("inf"), made))
    made = min(trials, key=lambda t: t[0])[1]
    return LobeForm(made.a, made.b, made.c, made.d, made.share, source=source)
