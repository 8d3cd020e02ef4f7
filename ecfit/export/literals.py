"""Numbers as source text: the shortest decimal that is read as the same number of the target's precision."""

import numpy as np

from ecfit.errors import EcfitError


def literal(value: float, *, double: bool = False, suffix: str = "") -> str:
    """A number as a literal with a decimal point or an exponent: "0.5f", "1e-6", "-3.0".

    Args:
        value: what is meant; rounded to single precision unless `double`.
        double: whether the target reads it in double precision.
        suffix: of the language, "f" or nothing.

    Raises `EcfitError` where the number is not finite in that precision.
    """
    with np.errstate(over="ignore"):
        rounded = np.float64(value) if double else np.float32(value)
    if not np.isfinite(rounded):
        raise EcfitError(f"the number {value!r} does not fit the target's precision")
    mantissa, _, exponent = str(rounded).partition("e")
    if exponent:
        mantissa = mantissa.removesuffix(".0")
        return f"{mantissa}e{int(exponent)}{suffix}"
    return f"{mantissa}{suffix}"
