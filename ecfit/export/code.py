"""`code`: an approximation as source text of a language."""

from collections.abc import Sequence

from ecfit.approximation import Approximation
from ecfit.export.contract import contract_lines
from ecfit.export.coordinates import Arguments, arguments
from ecfit.export.evidence import evidence_for
from ecfit.export.functions import Function
from ecfit.export.languages import Language, check_name, language
from ecfit.expressions import Node, cost
from ecfit.expressions.fold import folded


def code(
    approximation: Approximation,
    target: str,
    *,
    name: str | None = None,
    coordinates: Sequence[str] = (),
    clamp: bool = False,
    evidence: Sequence[str] | None = None,
) -> str:
    """Source text of a function that computes an approximation in single precision.

    Args:
        approximation: what is exported; a formula, not a table.
        target: name of a language; see `LANGUAGES`.
        name: of the function; by default the approximation's with underscores.
        coordinates: views in which arguments are taken, such as ("r", "ior"); by default the form's own.
            Their order is mu, alpha (or r), F0 (or ior), then others.
        clamp: whether arguments are clamped to the domain.
        evidence: lines of the comment on errors; by default those of the certificate of a shipped fit.

    Raises `EcfitError` for unknown languages and coordinates, names that the language reserves, and tables.
    """
    found = language(target)
    label = check_name(name if name is not None else default_name(approximation), found)
    taken = arguments(approximation, [coordinates] if isinstance(coordinates, str) else coordinates, clamp)
    function = value_function(approximation, label, taken)
    known = list(evidence) if evidence is not None else evidence_for(approximation)
    lines = contract_lines(approximation, label, taken, clamp, cost(function.value), known)
    return text(found, label, lines, [function])


def default_name(approximation: Approximation) -> str:
    """The approximation's name as a name of a function."""
    made = "".join(c if c.isascii() and c.isalnum() else "_" for c in approximation.name).strip("_")
    while "__" in made:
        made = made.replace("__", "_")
    return made if made and not made[0].isdigit() else f"fit_{made}"


def expression(approximation: Approximation, taken: Arguments) -> Node:
    """The expression that is exported, of the arguments: constants folded."""
    return folded(taken.transform(folded(approximation.expression())))


def value_function(approximation: Approximation, name: str, taken: Arguments) -> Function:
    """The function that computes the approximation."""
    known = approximation.formula.landmarks(approximation.variables)
    meanings = {folded(taken.transform(folded(node))): key for key, node in known.items()}
    note = f"{approximation.contract.quantity} of {approximation.contract.model}"
    return Function(name, taken.names, expression(approximation, taken), note, meanings=meanings)


def text(target: Language, name: str, comment: Sequence[str], functions: Sequence[Function]) -> str:
    """A whole file."""
    guard = f"{name.upper()}_{target.extension.upper()}"
    parts = ["\n".join((target.comment + line).rstrip() for line in comment)]
    if target.prologue:
        parts.append(target.prologue.format(guard=guard).rstrip("\n") + "\n" * (target.name == "python"))
    parts += ["\n".join(f.written(target)) for f in functions]
    return "\n\n".join(parts) + "\n" + (target.epilogue + "\n" if target.epilogue else "")
