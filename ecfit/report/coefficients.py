"""Published coefficients beside those of our fit of the same form."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ecfit.approximation import Approximation
from ecfit.approximation.formula import power_product
from ecfit.errors import EcfitError
from ecfit.fitting import Fit


@dataclass(frozen=True)
class Comparison:
    """Two coefficient vectors in the same monomials.

    Attributes:
        published, fit: names.
        note: what a variable stands for where the monomials are not those of the coordinate itself.
        rows: (part, monomial, published, recomputed).
    """

    published: str
    fit: str
    note: str
    rows: Sequence[tuple[str, str, float, float]]


def _same_form(published: Approximation, fit: Fit) -> bool:
    ours = fit.approximation
    if not (ours.is_quotient and published.is_quotient):
        return False
    return ours.variables == published.variables and all(
        np.array_equal(a, b)
        for a, b in (
            (ours.terms.numerator, published.terms.numerator),
            (ours.terms.denominator, published.terms.denominator),
        )
    )


def compare(published: Approximation, fits: Sequence[Fit]) -> list[Comparison]:
    """The published coefficients beside those of every fit with the same monomials."""
    found = []
    if not published.is_quotient:
        return found
    exponents = [
        *(("numerator", e) for e in published.terms.numerator),
        *(("denominator", e) for e in published.terms.denominator),
    ]
    scaled = [
        f"{v} stands for ({v} - {origin:g}) / {unit:g}"
        for v, (origin, unit) in zip(published.variables, published.scales, strict=True)
        if (origin, unit) != (0.0, 1.0)
    ]
    for fit in fits:
        if not _same_form(published, fit):
            continue
        try:
            ours = fit.approximation.in_scales(published.scales).coefficients
        except EcfitError:
            continue  # its denominator vanishes at the origin of the published monomials
        rows = [
            (part, power_product(published.variables, e), float(a), float(b))
            for (part, e), a, b in zip(exponents, published.coefficients, ours, strict=True)
        ]
        found.append(Comparison(published.name, fit.approximation.name, "; ".join(scaled), rows))
    return found
