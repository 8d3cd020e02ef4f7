"""A MaterialX library: node definitions, and their implementations as source code in GLSL, OSL and MSL.

Values of nodes are printed with six decimals by MaterialX's generators: coefficients are in the code only.
"""

import html
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ecfit.approximation import Approximation
from ecfit.export.code import Options, parts
from ecfit.export.functions import Function
from ecfit.export.languages import LANGUAGES, Language
from ecfit.export.lookups import TableFunction

VERSION = "1.39"


class _Target(NamedTuple):
    """A generator of MaterialX: its name, the language of its sources, and how they return a result."""

    name: str
    language: Language
    result: str


# MaterialX puts sources into files that have includes already; its functions return by reference.
_TARGETS = (
    _Target("genglsl", LANGUAGES["glsl"], "out {type} result"),
    _Target("genosl", LANGUAGES["osl"], "output {type} result"),
    _Target("genmsl", replace(LANGUAGES["msl"], prologue=""), "thread {type}& result"),
)

_PLAIN = Options()


def materialx(approximation: Approximation, options: Options = _PLAIN) -> dict[str, str]:
    """Files of a library by name: one `.mtlx` with a node for each function, one source a generator.

    The functions and their names are those of `ecfit.export.code` with the same options. Raises `EcfitError`
    as that does.
    """
    label, comment, functions = parts(approximation, LANGUAGES["glsl"], options)
    files = {f"{label}.mtlx": _library(label, comment, functions)}
    for target in _TARGETS:
        _, comment, functions = parts(approximation, target.language, options)
        files[f"{label}.{target.language.extension}"] = _source(target, comment, functions)
    return files


def _library(label: str, comment: Sequence[str], functions: Sequence[Function | TableFunction]) -> str:
    lines = ['<?xml version="1.0"?>', f'<materialx version="{VERSION}">', "  <!--"]
    # Two hyphens end a comment in XML.
    lines += [f"  {line.replace('--', '- -')}".rstrip() for line in comment]
    lines.append("  -->")
    for f in functions:
        lines.append(f'  <nodedef name="ND_{f.name}" node="{f.name}" nodegroup="math" '
                     f'doc="{html.escape(f.note)}">')  # fmt: skip
        for a in f.arguments:
            kind = _type(f, a)
            value = "1.0, 1.0, 1.0" if kind == "color3" else "0.5"
            lines.append(f'    <input name="{a}" type="{kind}" value="{value}" />')
        lines += [f'    <output name="out" type="{_type(f)}" />', "  </nodedef>"]
        for target in _TARGETS:
            lines.append(
                f'  <implementation name="IM_{f.name}_{target.name}" nodedef="ND_{f.name}" '
                f'target="{target.name}" file="{label}.{target.language.extension}" function="mx_{f.name}" />'
            )
    return "\n".join([*lines, "</materialx>"]) + "\n"


def _type(function: Function | TableFunction, argument: str = "") -> str:
    """MaterialX's type of an argument, or of the result."""
    colours = function.colours if isinstance(function, Function) else frozenset()
    return "color3" if (argument in colours if argument else bool(colours)) else "float"


def _source(target: _Target, comment: Sequence[str], functions: Sequence[Function | TableFunction]) -> str:
    language = target.language
    out = ["\n".join((language.comment + line).rstrip() for line in comment)]
    for f in functions:
        types = {"float": language.real, "color3": language.colour}
        given = [language.argument.format(type=types[_type(f, a)], name=a) for a in f.arguments]
        result = target.result.format(type=types[_type(f)])
        call = f"result = {f.name}({', '.join(f.arguments)});"
        out.append("\n".join(f.written(language)))
        out.append(f"void mx_{f.name}({', '.join([*given, result])})\n{{\n    {call}\n}}")
    return "\n\n".join(out) + "\n"
