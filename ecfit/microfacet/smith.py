"""Smith's masking and masking-shadowing, in forms that stay finite at mu = 0.

Separable: G2 = G1(wo) G1(wi) (Walter et al. 2007, eq. 23; what Sforza & Pellacini 2022 use).
Height-correlated: G2 = 1 / (1 + Lambda(wo) + Lambda(wi)) (Heitz 2014, eq. 99), which renderers use for
directions on opposite sides too. There Heitz et al. 2016 derive B(1 + Lambda(wo), 1 + Lambda(wi)), a Beta
function: "height-correlated-beta".
"""

from ecfit._jax import jax, jnp
from ecfit.microfacet.ndf import NDF

Array = jax.Array

MASKINGS = ("separable", "height-correlated")
# Where light may pass to the other side.
INTERFACE_MASKINGS = (*MASKINGS, "height-correlated-beta")

# Stands for a cosine of 0 in the Beta function, which loses its digits further down.
_LEAST = 1e-9


def Lambda(ndf: NDF, mu: Array, alpha: Array) -> Array:
    """Smith's Lambda at mu = |cos theta| in (0, 1]."""
    return ndf.mu_lambda(mu, alpha) / mu


def G1(ndf: NDF, mu: Array, alpha: Array) -> Array:
    """Masking G1 = 1 / (1 + Lambda), in [0, 1], for mu in [0, 1] (not mu = alpha = 0)."""
    return mu / (mu + ndf.mu_lambda(mu, alpha))


def masking_shadowing(
    ndf: NDF, masking: str, mu_o: Array, mu_i: Array, alpha: Array, *, opposite: bool = False
) -> Array:
    """G2(mu_o, mu_i) / (mu_o mu_i), finite for mu_o = 0 or mu_i = 0 (both: not at alpha = 0).

    This quotient is what every microfacet BSDF contains. With m = mu + mu Lambda(mu) = mu / G1:
    separable 1 / (m_o m_i); height-correlated 1 / (m_o mu_i + mu_o m_i - mu_o mu_i).
    Both are 0 where a denominator vanishes (a direction in a mirror's plane). `opposite` says that the
    directions are on opposite sides, which matters for "height-correlated-beta" only.
    """
    m_o = mu_o + ndf.mu_lambda(mu_o, alpha)
    m_i = mu_i + ndf.mu_lambda(mu_i, alpha)
    d = m_o * m_i if masking == "separable" else m_o * mu_i + mu_o * m_i - mu_o * mu_i
    quotient = jnp.where(d > 0.0, 1.0 / jnp.where(d > 0.0, d, 1.0), 0.0)
    if masking != "height-correlated-beta" or not opposite:
        return quotient
    # B(1 + a, 1 + b) = Gamma(1 + a) Gamma(1 + b) / Gamma(2 + a + b) with a = m_o / mu_o - 1 and b likewise.
    o, i = jnp.maximum(mu_o, _LEAST), jnp.maximum(mu_i, _LEAST)
    return jnp.exp(_log_beta(m_o / o, m_i / i)) / (o * i)


def _log_beta(a: Array, b: Array) -> Array:
    """log B(a, b): JAX's betaln has 7 digits only for small arguments, log gamma has none for large ones."""
    log_gamma = jax.scipy.special.gammaln
    small = a + b < 1e3
    p, q = jnp.where(small, a, 1.0), jnp.where(small, b, 1.0)
    exact = log_gamma(p) + log_gamma(q) - log_gamma(p + q)
    return jnp.where(small, exact, jax.scipy.special.betaln(a, b))


def G2(ndf: NDF, masking: str, mu_o: Array, mu_i: Array, alpha: Array) -> Array:
    """Masking-shadowing of a reflection, in [0, 1]."""
    return mu_o * mu_i * masking_shadowing(ndf, masking, mu_o, mu_i, alpha)
