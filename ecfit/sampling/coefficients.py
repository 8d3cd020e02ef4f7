"""a, b, c, d of transformed cosines and the share of a uniform lobe, as functions of mu and roughness.

Their numbers are data: one JSON file a set in `ecfit/data/sampling`.
"""

from importlib import resources
from pathlib import Path

import equinox as eqx
import numpy as np

from ecfit._jax import jax, jnp
from ecfit.errors import EcfitError, unknown
from ecfit.files import read_json
from ecfit.sampling.cosine import TransformedCosine

Array = jax.Array

# Numbers of each function, and of the share's polynomial with its exponent.
_COUNTS = {"a": 5, "b": 5, "c": 3, "d": 5, "share": 5}


class LobeForm(eqx.Module):
    """Rational functions of mu and roughness r in [0, 1], 18 numbers, and a share of 5.

    Attributes:
        a: of 1 + r (a0 + a1 mu + a2 mu^2 + r (a3 + a4 mu)).
        b: of r (b0 + b1 mu + r (b2 + b3 mu)) / (mu^3 + b4).
        c: of 1 + r (c0 + c1 mu + c2 mu^2).
        d: of r (d0 + d1 mu + d2 mu^2) / (d3 + d4 mu + mu^2).
        share: probability of the uniform lobe, r^s0 (s1 + s2 mu + s3 mu^2 + s4 mu^3).
        source: who made the numbers.

    The form is that of Portsmouth et al. 2024, listings 2 and 4.
    """

    a: Array
    b: Array
    c: Array
    d: Array
    share: Array
    source: str = eqx.field(static=True, default="")

    def matrix(self, mu: Array, r: Array, clipped: bool = True) -> TransformedCosine:
        """The transformed cosine at scalars mu and r."""
        a, b, c, d = self.a, self.b, self.c, self.d
        return TransformedCosine(
            1.0 + r * (a[0] + (a[1] + a[2] * mu) * mu + (a[3] + a[4] * mu) * r),
            r * (b[0] + b[1] * mu + (b[2] + b[3] * mu) * r) / (mu * mu * mu + b[4]),
            1.0 + r * (c[0] + (c[1] + c[2] * mu) * mu),
            r * (d[0] + (d[1] + d[2] * mu) * mu) / (d[3] + (d[4] + mu) * mu),
            clipped,
        )

    def uniform(self, mu: Array, r: Array) -> Array:
        """Probability of the uniform lobe; 0 at r = 0."""
        s = self.share
        root = jnp.where(r > 0.0, jnp.where(r > 0.0, r, 1.0) ** s[0], 0.0)
        return root * (s[1] + (s[2] + (s[3] + s[4] * mu) * mu) * mu)

    @property
    def count(self) -> int:
        """Numbers of the form."""
        return sum(_COUNTS.values())


def _folder() -> Path:
    return Path(str(resources.files("ecfit"))) / "data" / "sampling"


def lobe_forms() -> list[str]:
    """Names that `lobe_form` accepts."""
    return sorted(path.stem for path in _folder().glob("*.json"))


def lobe_form(name: str) -> LobeForm:
    """A set of numbers by name: `portsmouth-2024`, or `eon` fitted here.

    Raises `EcfitError` for an unknown name (it lists the known ones) and for a file of other counts.
    """
    if name not in lobe_forms():
        raise unknown("lobe form", name, lobe_forms())
    data = read_json(_folder() / f"{name}.json")
    arrays = {}
    for key, count in _COUNTS.items():
        numbers = np.asarray(data.get(key, ()), dtype=np.float64)
        if numbers.shape != (count,):
            raise EcfitError(f"lobe form '{name}': {key} must be {count} numbers, got {numbers.shape}")
        arrays[key] = jnp.asarray(numbers)
    return LobeForm(**arrays, source=str(data.get("source", "")))
