"""Sheen: cloth-like lobes that scatter towards grazing directions."""

from ecfit._jax import jax, jnp
from ecfit.bsdf.base import BSDF, parameter
from ecfit.bsdf.registry import register

Array = jax.Array

# Stands for a width of 0, at which the exponent is -infinity all the same.
_LEAST_WIDTH = 1e-3


def _visibility(mu_o: Array, mu_i: Array) -> Array:
    """1 / (4 (mu_o + mu_i - mu_o mu_i)) (Neubelt & Pettineo 2013, section on cloth)."""
    return 0.25 / (mu_o + mu_i - mu_o * mu_i)


def _sin2_half(wo: Array, wi: Array) -> tuple[Array, Array]:
    """sin^2 and cos^2 of theta_h, the former without cancellation near the normal."""
    h = wo + wi
    length = jnp.dot(h, h)
    return (h[0] * h[0] + h[1] * h[1]) / length, h[2] * h[2] / length


def inverted_gaussian(b: Array, wo: Array, wi: Array) -> Array:
    """Ashikhmin's cloth BRDF D_inv / (4 (l + v - l v)) of unit vectors above the surface.

    D_inv = (1 + 4 exp(-cot^2(theta_h) / b^2) / sin^4(theta_h)) / (pi (1 + 4 b^2))
    (Ashikhmin & Premoze 2007; Enterprise PBR 2019x, Sheen BRDF). b = 0 is the limit 1 / (4 pi (l + v - l v)).
    """
    s2, c2 = _sin2_half(wo, wi)
    width = jnp.maximum(b, _LEAST_WIDTH)
    # exp(-x) x^2 underflows long before sin^4 does.
    s2 = jnp.maximum(s2, 1e-12)
    peak = 4.0 * jnp.exp(-c2 / (s2 * width * width)) / (s2 * s2)
    return (1.0 + peak) / (jnp.pi * (1.0 + 4.0 * b * b)) * _visibility(wo[2], wi[2])


def _above(wo: Array, wi: Array) -> tuple[Array, Array]:
    """Whether wi is above the surface, and wi or a safe stand-in."""
    above = (wo[2] > 0.0) & (wi[2] > 0.0)
    return above, jnp.where(above, wi, jnp.array([0.0, 0.0, 1.0]))


@register("ashikhmin-sheen")
class AshikhminSheen(BSDF):
    """M_b of Enterprise PBR 2019x: the inverted Gaussian distribution with the cloth visibility."""

    b: Array = parameter(0.5, 0.0, 1.0, "width of the inverted Gaussian, the document's sheen")

    def f(self, wo: Array, wi: Array) -> Array:
        above, wi = _above(wo, wi)
        return jnp.where(above, inverted_gaussian(self.b, wo, wi), 0.0)


@register("imageworks-sheen")
class ImageworksSheen(BSDF):
    """D / (4 (l + v - l v)) with D = (2 + 1 / r) sin(theta_h)^(1 / r) / (2 pi) (Estevez & Kulla 2017, eq. 2).

    As MaterialX has it: the width of the distribution is r itself, not its square.
    """

    r: Array = parameter(0.5, 0.01, 1.0, "width of the distribution, not squared")

    # A narrow distribution stands upright: its albedo is 1.157 at r = 0.1, mu = 0.02.
    conserving = False

    def f(self, wo: Array, wi: Array) -> Array:
        above, wi = _above(wo, wi)
        s2, _ = _sin2_half(wo, wi)
        inverse = 1.0 / self.r
        d = (2.0 + inverse) * jnp.maximum(s2, 1e-300) ** (0.5 * inverse) / (2.0 * jnp.pi)
        return jnp.where(above, d * _visibility(wo[2], wi[2]), 0.0)
