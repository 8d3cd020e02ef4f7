"""What a page offers to copy of an approximation: code in the languages of `ecfit.export`, and its JSON."""

import json
from dataclasses import dataclass
from importlib import import_module

from ecfit.approximation import Approximation
from ecfit.errors import EcfitError

# Name in `ecfit.export` -> what people call it, in the order of the page's list.
LANGUAGES = {
    "glsl": "GLSL",
    "hlsl": "HLSL",
    "wgsl": "WGSL",
    "msl": "Metal",
    "slang": "Slang",
    "osl": "OSL",
    "c": "C, C++",
    "python": "Python",
}


@dataclass(frozen=True)
class Code:
    """One block of text to copy: language for people, its short name, the text."""

    label: str
    language: str
    text: str


def codes(approximation: Approximation) -> list[Code]:
    """An approximation in every language that can hold it, and as the JSON that `ecfit.Approximation` reads.

    What no language can hold (a large table) is left out.
    """
    out = []
    for language, label in LANGUAGES.items():
        text = _exported(approximation, language)
        if text:
            out.append(Code(label, language, text))
    if approximation.form != "lookup":
        out.append(Code("JSON", "json", json.dumps(approximation.to_dict(), indent=1, ensure_ascii=False)))
    return out


def _exported(approximation: Approximation, language: str) -> str:
    try:
        return import_module("ecfit.export").code(approximation, language)
    except (ModuleNotFoundError, EcfitError):
        return ""
