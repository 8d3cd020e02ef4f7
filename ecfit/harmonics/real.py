"""Real spherical harmonics up to degree 2, in the order (0,0), (1,-1), (1,0), (1,1), (2,-2), ..., (2,2)."""

import math

from ecfit._jax import jax, jnp

Array = jax.Array

# The degree l of each of the nine harmonics.
DEGREES = (0, 1, 1, 1, 2, 2, 2, 2, 2)

_C0 = 0.5 / math.sqrt(math.pi)
_C1 = 0.5 * math.sqrt(3.0 / math.pi)
_C2 = 0.5 * math.sqrt(15.0 / math.pi)
_C20 = 0.25 * math.sqrt(5.0 / math.pi)


def spherical_harmonics(direction: Array) -> Array:
    """The nine real harmonics Y_lm, l <= 2, of unit vectors: shape (..., 3) to (..., 9).

    Orthonormal over the sphere, without the phase (-1)^m, as in graphics (Ramamoorthi & Hanrahan 2001).
    """
    x, y, z = (direction[..., i] for i in range(3))
    return jnp.stack(
        [
            jnp.full_like(x, _C0),
            _C1 * y,
            _C1 * z,
            _C1 * x,
            _C2 * x * y,
            _C2 * y * z,
            _C20 * (3.0 * z * z - 1.0),
            _C2 * x * z,
            0.5 * _C2 * (x * x - y * y),
        ],
        axis=-1,
    )
