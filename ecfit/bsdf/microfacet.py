"""The value of one microfacet lobe, shared by the models made of such lobes."""

from ecfit._jax import jax, jnp
from ecfit.microfacet import NDFS, Fresnel, masking_shadowing

Array = jax.Array

_UP = (0.0, 0.0, 1.0)


def reflection(ndf: str, masking: str, alpha: Array, fresnel: Fresnel, wo: Array, wi: Array) -> Array:
    """F(wo.h) D(h) G2 / (4 mu_o mu_i) for wi above the horizon, else 0 (Walter et al. 2007, eq. 20)."""
    above = (wo[2] > 0.0) & (wi[2] > 0.0)
    # A safe stand-in below the horizon keeps gradients finite.
    wi = jnp.where(above, wi, jnp.array(_UP))
    h = wo + wi
    h = h / jnp.linalg.norm(h)
    x = jnp.minimum(jnp.dot(wo, h), 1.0)
    d = NDFS[ndf].D(h[2], alpha)
    g = masking_shadowing(NDFS[ndf], masking, wo[2], wi[2], alpha)
    return jnp.where(above, 0.25 * fresnel(x) * d * g, 0.0)


def refraction(
    ndf: str, masking: str, alpha: Array, fresnel: Fresnel, eta: Array, wo: Array, wi: Array
) -> Array:
    """(1 - F) D G2 |wo.h| |wi.h| / (mu_o mu_i (wo.h + eta wi.h)^2) for wi below the horizon, else 0.

    Walter et al. 2007, eq. 21, as the radiance BSDF; eta = n_transmitted / n_incident as seen by wo. At
    eta = 1 all light passes straight through: a delta function, of which this is 0.
    """
    below = (wo[2] > 0.0) & (wi[2] < 0.0) & (eta != 1.0)
    wi = jnp.where(below, wi, -jnp.array(_UP))
    eta = jnp.where(below, eta, 2.0)
    h = wo + eta * wi
    h = jnp.where(h[2] < 0.0, -h, h) / jnp.maximum(jnp.linalg.norm(h), 1e-150)
    x, y = jnp.dot(wo, h), jnp.dot(wi, h)
    # wo and wi see the microfacet from its two sides.
    valid = below & (x > 0.0) & (y < 0.0) & (h[2] > 0.0)
    x, y, c = jnp.where(valid, x, 1.0), jnp.where(valid, y, -1.0), jnp.where(valid, h[2], 1.0)
    x = jnp.minimum(x, 1.0)
    d = NDFS[ndf].D(c, alpha)
    g = masking_shadowing(NDFS[ndf], masking, wo[2], -wi[2], alpha, opposite=True)
    # At eta != 1 the sum vanishes nowhere: it is the length of wo + eta wi, up to its sign.
    return jnp.where(valid, (1.0 - fresnel(x)) * d * g * jnp.abs(x * y) / (x + eta * y) ** 2, 0.0)
