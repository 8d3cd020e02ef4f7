"""Numbers as files store them: floats of three sizes and whole numbers, and what rounding to them costs."""

from dataclasses import dataclass

import numpy as np

from ecfit.errors import EcfitError, unknown


@dataclass(frozen=True)
class Number:
    """A type of number. `one`: what stands for 1 (1 for floats, else the largest whole number)."""

    name: str
    dtype: str
    one: float

    @property
    def whole(self) -> bool:
        return self.one != 1.0

    def encode(self, values: np.ndarray) -> np.ndarray:
        """Values as stored, rounded to nearest.

        Raises `EcfitError` for values that the type cannot hold: outside [0, 1] for whole numbers, beyond
        65504 for halves.
        """
        low, high = float(values.min()), float(values.max())
        if self.whole:
            # An integral may be off the end of its range by its own error.
            if low < -0.5 / self.one or high > 1.0 + 0.5 / self.one:
                raise EcfitError(
                    f"{self.name} holds 0 to 1, the values are in [{low:.4g}, {high:.4g}]: use a float type"
                )
            return np.rint(np.clip(values, 0.0, 1.0) * self.one).astype(self.dtype)
        with np.errstate(over="ignore"):
            array = values.astype(self.dtype)
        if not np.isfinite(array).all():
            raise EcfitError(f"{self.name} cannot hold values in [{low:.4g}, {high:.4g}]")
        return array

    def decode(self, stored: np.ndarray) -> np.ndarray:
        """The numbers that `encode` rounded, float64."""
        return stored.astype(np.float64) / self.one

    def step(self, largest: float) -> float:
        """The most by which rounding moves a value of at most `largest`."""
        if self.whole:
            return 0.5 / self.one
        return 0.5 * float(np.spacing(np.abs(np.asarray(largest, dtype=self.dtype))))


NUMBERS: dict[str, Number] = {
    n.name: n
    for n in (
        Number("float64", "<f8", 1.0),
        Number("float32", "<f4", 1.0),
        Number("float16", "<f2", 1.0),
        Number("uint16", "<u2", 65535.0),
        Number("uint8", "|u1", 255.0),
    )
}


def number(name: str) -> Number:
    """A type of number by its name. Raises `EcfitError` for an unknown one."""
    if not isinstance(name, str) or name not in NUMBERS:
        raise unknown("type of number", name, NUMBERS)
    return NUMBERS[name]
