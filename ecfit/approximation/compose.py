"""Approximations made of others."""

from collections.abc import Mapping

from ecfit.approximation.approximation import Approximation
from ecfit.approximation.composed import KINDS, Composed, Part
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.forms.features import COORDINATES


def compose(
    name: str,
    text: str,
    parts: Mapping[str, Approximation],
    contract: Contract,
    within: Mapping[str, tuple[float, float]] | None = None,
) -> Approximation:
    """An approximation made of others.

    Args:
        name: what reports call it.
        text: the value in the names of the parts, such as "E1 * E_spec".
        parts: approximations by what the text calls them; structured forms or written formulas.
        contract: what the whole approximates.
        within: ranges of variables that the domain does not exceed.

    Its variables are all of the parts', its domain is where all are defined. Raises `EcfitError` for parts
    that are none of these, and for ranges that have nothing in common.
    """
    ranges: dict[str, tuple[float, float]] = dict(within or {})
    for label, part in parts.items():
        if part.formula.kind not in KINDS:
            raise EcfitError(f"part '{label}' is a {part.formula.kind}: only {', '.join(KINDS)} compose")
        for variable, (low, high) in zip(part.variables, part.domain, strict=True):
            old = ranges.get(variable, (low, high))
            ranges[variable] = max(old[0], low), min(old[1], high)
    for variable, (low, high) in ranges.items():
        if not low < high:
            raise EcfitError(f"parts of '{name}' have no {variable} in common")
    names = tuple(v for v in COORDINATES if v in ranges)
    made = tuple(Part(label, part.variables, part.formula) for label, part in parts.items())
    return Approximation(
        name=name,
        form="composed",
        degree="+".join(str(part.count) for part in parts.values()),
        variables=names,
        formula=Composed(names, text, made),
        domain=tuple(ranges[v] for v in names),
        contract=contract,
    )
