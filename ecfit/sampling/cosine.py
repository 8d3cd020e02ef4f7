"""Linearly transformed cosines, whole and clipped to the upper hemisphere.

Heitz et al. 2016; clipping: Portsmouth et al. 2024, section 3.1, whose equation numbers these are. Directions
are given in the frame of the view: wo = (sin theta_o, 0, cos theta_o).
"""

import equinox as eqx

from ecfit._jax import jax, jnp

Array = jax.Array


class TransformedCosine(eqx.Module):
    """The clamped cosine under M = [[a, 0, b], [0, c, 0], [d, 0, 1]], det M > 0 (eq. 22 to 25).

    Attributes:
        a, b, c, d: scalars.
        clipped: whether only what M maps to the upper hemisphere is drawn (eq. 28); else directions fall
            below the horizon, too, where they are wasted.
    """

    a: Array
    b: Array
    c: Array
    d: Array
    clipped: bool = eqx.field(static=True, default=True)

    @property
    def determinant(self) -> Array:
        """Of the matrix that stretches the cosine."""
        return self.c * (self.a - self.b * self.d)

    @property
    def share(self) -> Array:
        """What clipping keeps of the cosine: its integral over the part with M w above the horizon."""
        return 0.5 * (1.0 + 1.0 / jnp.sqrt(1.0 + self.d * self.d))

    def pdf(self, wi: Array) -> Array:
        """Density per steradian (eq. 23, 24 and 28) of a unit vector of shape (3,); 0 below the horizon if
        clipped."""
        x, y, z = wi[0], wi[1], wi[2]
        # adj(M) wi: M^-1 wi times the determinant.
        h = jnp.stack([
            self.c * (x - self.b * z),
            (self.a - self.b * self.d) * y,
            self.c * (self.a * z - self.d * x),
        ])  # fmt: skip
        square = jnp.dot(h, h)
        whole = self.determinant**2 * jnp.maximum(h[2], 0.0) / (jnp.pi * square * square)
        if not self.clipped:
            return whole
        return jnp.where(z > 0.0, whole / self.share, 0.0)

    def sample(self, u: Array) -> Array:
        """A unit vector of that density from two uniform numbers, shape (2,) -> (3,)."""
        radius, phi = jnp.sqrt(u[0]), 2.0 * jnp.pi * u[1]
        x, y = radius * jnp.cos(phi), radius * jnp.sin(phi)
        if self.clipped:
            # The disc squeezed into a half disc and a half ellipse, which lies on the side that M turns down.
            rim = jnp.sqrt(jnp.maximum(1.0 - y * y, 0.0))
            x = jnp.where(self.d > 0.0, 1.0, -1.0) * (rim + (x - rim) * self.share)
        z = jnp.sqrt(jnp.maximum(1.0 - x * x - y * y, 0.0))
        w = jnp.stack([self.a * x + self.b * z, self.c * y, self.d * x + z])
        return w / jnp.linalg.norm(w)
