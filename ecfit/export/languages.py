"""The languages, as data: how each writes types, declarations, functions and a few operations."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ecfit.errors import EcfitError, unknown
from ecfit.export.reserved import RESERVED

# How an operation reads; {0} and {1} are its arguments. Sums, products, quotients and signs are alike
# everywhere.
Calls = Mapping[str, str]

_SHADER: Calls = {
    "sqrt": "sqrt({0})", "exp": "exp({0})", "exp2": "exp2({0})", "log": "log({0})", "abs": "abs({0})",
    "pow": "pow({0}, {1})", "min": "min({0}, {1})", "max": "max({0}, {1})", "step": "step({1}, {0})",
}  # fmt: skip
# As comparisons min and max are one instruction each; fminf and fmaxf, which treat NaN, are often calls.
_C: Calls = {
    "sqrt": "sqrtf({0})", "exp": "expf({0})", "exp2": "exp2f({0})", "log": "logf({0})", "abs": "fabsf({0})",
    "pow": "powf({0}, {1})", "min": "({0} < {1} ? {0} : {1})", "max": "({0} > {1} ? {0} : {1})",
    "step": "({0} >= {1} ? 1.0f : 0.0f)",
}  # fmt: skip
_CPP: Calls = {
    "sqrt": "std::sqrt({0})", "exp": "std::exp({0})", "exp2": "std::exp2({0})", "log": "std::log({0})",
    "abs": "std::abs({0})", "pow": "std::pow({0}, {1})", "min": "std::min({0}, {1})",
    "max": "std::max({0}, {1})", "step": "({0} >= {1} ? 1.0f : 0.0f)",
}  # fmt: skip
# Only what NumPy, JAX and Dr.Jit have under one name; Dr.Jit lacks what derivatives of limits need.
_PYTHON: Calls = {
    "sqrt": "xp.sqrt({0})", "exp": "xp.exp({0})", "exp2": "xp.power(2.0, {0})", "log": "xp.log({0})",
    "abs": "xp.abs({0})", "pow": "xp.power({0}, {1})", "min": "xp.minimum({0}, {1})",
    "max": "xp.maximum({0}, {1})", "step": "xp.heaviside({0} - {1}, 1.0)",
}  # fmt: skip


@dataclass(frozen=True)
class Language:
    """How a language writes a function of numbers.

    Attributes:
        name: how users call it.
        title: its name for people.
        extension: of its files, without the dot.
        signature: start of a function; {result}, {name} and {arguments} are filled in.
        argument: one argument: {type} and {name}.
        declare: a local constant: {name} and {value}.
        real, colour: types of a number and of an RGB value, {type} in the above. Without colours of its own a
            language has numbers there, one call a channel.
        calls: how operations read.
        suffix: of literals.
        double: whether literals are read in double precision.
        comment: what a line of comment starts with.
        end: the last line of a function.
        stop: what ends a statement.
        prologue, epilogue: before and after all functions; {guard} is a name in capitals.
        joined: how a long statement goes on in the next line: "" where line breaks do not matter, else the
            pair of brackets that it needs.
        after: further line ends after each part of a file.
        array: start of an array of constants, {name} and {size}; none where tables belong into textures.
        unused: a statement that keeps compilers from warning of the argument {name} that nothing uses.
    """

    name: str
    title: str
    extension: str
    signature: str = "{result} {name}({arguments})\n{{"
    argument: str = "{type} {name}"
    declare: str = "const float {name} = {value};"
    real: str = "float"
    colour: str = "float3"
    calls: Calls = field(default_factory=lambda: _SHADER)
    suffix: str = ""
    double: bool = False
    comment: str = "// "
    end: str = "}"
    stop: str = ";"
    prologue: str = ""
    epilogue: str = ""
    joined: str = ""
    unused: str = ""
    after: str = ""
    array: str = ""

    @property
    def keywords(self) -> frozenset[str]:
        """Names that mean something else in the language."""
        return RESERVED[self.name]


_ARRAY = "static const float {name}[{size}] = {{"
_VOID = "(void){name};"
_GUARDED = "#ifndef {guard}\n#define {guard}\n\n#include <math.h>\n"

LANGUAGES: Mapping[str, Language] = MappingProxyType({
    found.name: found
    for found in (
        # Not const: in ESSL 3.00 that is for constant expressions only.
        Language("glsl", "GLSL", "glsl", declare="float {name} = {value};", colour="vec3"),
        Language("hlsl", "HLSL", "hlsl", suffix="f"),
        Language(
            "wgsl", "WGSL", "wgsl", "fn {name}({arguments}) -> {result} {{", "{name}: {type}",
            "let {name}: f32 = {value};", "f32", "vec3<f32>",
        ),
        Language(
            "msl", "Metal", "metal", "static inline {result} {name}({arguments})\n{{", suffix="f",
            prologue="#include <metal_stdlib>\nusing namespace metal;\n", unused=_VOID,
        ),
        Language("slang", "Slang", "slang", suffix="f"),
        Language("osl", "OSL", "osl", declare="float {name} = {value};", colour="color"),
        Language(
            "c", "C", "h", "static inline {result} {name}({arguments})\n{{", colour="float", calls=_C,
            suffix="f", prologue=_GUARDED, epilogue="\n#endif", unused=_VOID, array=_ARRAY,
        ),
        Language(
            "cpp", "C++", "hpp", "inline {result} {name}({arguments})\n{{", colour="float", calls=_CPP,
            suffix="f",
            prologue="#ifndef {guard}\n#define {guard}\n\n#include <algorithm>\n#include <cmath>\n",
            epilogue="\n#endif", unused=_VOID, array=_ARRAY,
        ),
        Language(
            "python", "Python", "py", "def {name}({arguments}, *, xp=numpy):", "{name}", "{name} = {value}",
            calls=_PYTHON, double=True, comment="# ", end="", stop="", prologue="import numpy",
            joined="()", after="\n",
        ),
    )
})  # fmt: skip


def language(name: str, also: Iterable[str] = ()) -> Language:
    """A language by name. Raises `EcfitError` for an unknown one: it lists the known, and what is `also`."""
    if name not in LANGUAGES:
        raise unknown("language", name, [*LANGUAGES, *also])
    return LANGUAGES[name]


def check_name(name: str, target: Language, arguments: Iterable[str] = ()) -> str:
    """A name that a function may have in the language, in a file where functions take `arguments`.

    Raises `EcfitError` for what is no identifier in ASCII, is reserved there, has two underscores in a row
    (which GLSL, C and C++ keep for themselves), or is the name of an argument, which would hide the function.
    """
    if not (name.isascii() and name.isidentifier()):
        raise EcfitError(
            f"'{name}' is no name of a function: use letters, digits and underscores, no digit first"
        )
    if name in target.keywords:
        raise EcfitError(f"'{name}' is reserved in {target.title}: choose another name")
    if "__" in name or name.startswith("_"):
        raise EcfitError(f"'{name}': {target.title} reserves such underscores: choose another name")
    if name in set(arguments):
        raise EcfitError(f"'{name}' is the name of an argument: choose another name")
    return name
