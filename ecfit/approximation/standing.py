"""What an approximation is that a study judges beside its own fits."""

from ecfit.approximation.approximation import OURS, Approximation
from ecfit.forms import Minimum


def standing(approximation: Approximation) -> str:
    """What is judged beside a study's fits: "table" (a look-up), "shipped" (with ecfit) or "published"."""
    if approximation.form == "lookup":
        return "table"
    return "shipped" if approximation.source == OURS else "published"


def standing_status(approximation: Approximation, smallest: Minimum) -> str:
    """The same as a status in words: a pole is said."""
    kind = standing(approximation)
    return kind if smallest.bound > 0.0 else f"{kind}, pole"
