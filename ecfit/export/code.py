"""`code`: an approximation as source text of a language."""

from collections.abc import Sequence
from dataclasses import dataclass

from ecfit.approximation import Approximation, Lookup, Quotient, Written
from ecfit.export.compensation import LEAST, factors
from ecfit.export.contract import contract_lines
from ecfit.export.coordinates import Arguments, arguments
from ecfit.export.evidence import evidence_for
from ecfit.export.functions import Function
from ecfit.export.languages import Language, check_name, language
from ecfit.export.lookups import TableFunction, table_function
from ecfit.export.nest import nested_sums
from ecfit.export.slopes import slope
from ecfit.expressions import Node, cost
from ecfit.expressions.fold import folded

# Formulas whose expressions are sums as printed by their authors.
_PLAIN = (Quotient.kind, Written.kind)


@dataclass(frozen=True)
class Options:
    """What one may choose in an export; see `code`."""

    name: str | None = None
    coordinates: tuple[str, ...] = ()
    clamp: bool = False
    factor: bool = False
    least: float = LEAST
    derivative: str = ""
    evidence: Sequence[str] | None = None


def code(
    approximation: Approximation,
    target: str,
    *,
    name: str | None = None,
    coordinates: Sequence[str] = (),
    clamp: bool = False,
    factor: bool = False,
    least: float = LEAST,
    derivative: str = "",
    evidence: Sequence[str] | None = None,
) -> str:
    """Source text of a function that computes an approximation in single precision.

    Args:
        approximation: what is exported; a table, which is read linearly and clamps, in C and C++ only.
        target: name of a language; see `LANGUAGES`.
        name: of the function; by default the approximation's with underscores.
        coordinates: views in which arguments are taken, such as ("r", "ior"); by default the form's own.
            Their order is mu, alpha (or r), F0 (or ior), then others.
        clamp: whether arguments are clamped to the domain.
        factor: whether `name_factor` follows, 1 / E, and for a conductor `name_metal` with a colour F0.
        least: E is raised to this where 1 / E is meant.
        derivative: an argument by which `name_d<argument>` follows, the slope of the value.
        evidence: lines of the comment on errors; by default those of the certificate of a shipped fit.

    Raises `EcfitError` for unknown languages, coordinates and arguments, names that the language reserves,
    tables elsewhere than in C, and factors of what is no albedo.
    """
    options = Options(name, tuple(_listed(coordinates)), clamp, factor, least, derivative, evidence)
    found = language(target)
    return text(found, *parts(approximation, found, options))


def _listed(names: Sequence[str]) -> Sequence[str]:
    return [names] if isinstance(names, str) else names


def parts(
    approximation: Approximation, target: Language, options: Options
) -> tuple[str, list[str], list[Function | TableFunction]]:
    """The name of the main function, lines of the comment, and all functions, of a file in a language.

    Raises `EcfitError` as `code`.
    """
    label = check_name(options.name or default_name(approximation), target)
    table = isinstance(approximation.formula, Lookup)
    clamped = options.clamp or table
    taken = arguments(approximation, options.coordinates, clamped)
    functions: list[Function | TableFunction]
    if table:
        functions = [table_function(approximation, label, taken)]
    else:
        functions = [value_function(approximation, label, taken)]
    if options.factor:
        functions += factors(approximation, label, taken, options.least)
    if options.derivative:
        functions.append(slope(functions[0], taken, options.derivative))
    every = {name for f in functions for name in f.arguments}
    for f in functions:
        check_name(f.name, target, every)
    first, known = functions[0], options.evidence
    evidence = list(known) if known is not None else evidence_for(approximation)
    price = cost(first.value) if isinstance(first, Function) else None
    return label, contract_lines(approximation, label, taken, clamped, price, evidence), functions


def default_name(approximation: Approximation) -> str:
    """The approximation's name as a name of a function."""
    made = "".join(c if c.isascii() and c.isalnum() else "_" for c in approximation.name).strip("_")
    while "__" in made:
        made = made.replace("__", "_")
    return made if made and not made[0].isdigit() else f"fit_{made}"


def expression(approximation: Approximation, taken: Arguments) -> Node:
    """The expression that is exported, of the arguments."""
    return _tidied(approximation.expression(), approximation, taken)


def _tidied(node: Node, approximation: Approximation, taken: Arguments) -> Node:
    # Our own forms are nested already, as their certificates have them.
    plain = folded(node)
    nested = nested_sums(plain) if approximation.formula.kind in _PLAIN else plain
    return folded(taken.transform(nested))


def value_function(approximation: Approximation, name: str, taken: Arguments) -> Function:
    """The function that computes the approximation."""
    known = approximation.formula.landmarks(approximation.variables)
    meanings = {_tidied(node, approximation, taken): key for key, node in known.items()}
    note = f"{approximation.contract.quantity} of {approximation.contract.model}"
    return Function(name, taken.names, expression(approximation, taken), note, meanings=meanings)


def text(
    target: Language, name: str, comment: Sequence[str], functions: Sequence[Function | TableFunction]
) -> str:
    """A whole file."""
    guard = f"{name.upper()}_{target.extension.upper()}"
    parts = ["\n".join((target.comment + line).rstrip() for line in comment)]
    if target.prologue:
        parts.append(target.prologue.format(guard=guard))
    parts += ["\n".join(f.written(target)) for f in functions]
    whole = "\n\n".join(part.strip("\n") + target.after for part in parts).rstrip("\n")
    return f"{whole}\n{target.epilogue}\n" if target.epilogue else f"{whole}\n"
