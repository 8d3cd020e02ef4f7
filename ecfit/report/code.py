"""What a page offers to copy of an approximation: code in the languages of `ecfit.export`, and its JSON."""

import json
from dataclasses import dataclass, replace

from ecfit.errors import EcfitError
from ecfit.export import LANGUAGES, code, evidence_of
from ecfit.export.code import default_name
from ecfit.report.entries import Entry

# The others are told by one of these: what compiles as C does as C++.
_LEFT_OUT = ("cpp",)


@dataclass(frozen=True)
class Code:
    """One block of text to copy: language for people, its short name, the text."""

    label: str
    language: str
    text: str


def codes(entry: Entry, table: str) -> list[Code]:
    """An approximation in every language that can hold it, and as the JSON that `ecfit.Approximation` reads.

    The function of a fit is named after its table too, so that those of a study do not clash. Nothing for
    look-up tables, which renderers fetch.
    """
    approximation = entry.approximation
    if approximation.form == "lookup":
        return []
    evidence = evidence_of(entry.fit.to_dict()) if entry.fit is not None else None
    named = replace(approximation, name=f"{table}_{entry.name}") if entry.fit is not None else approximation
    function = default_name(named)
    out: list[Code] = []
    for name, language in LANGUAGES.items():
        if name in _LEFT_OUT:
            continue
        try:
            text = code(approximation, name, name=function, evidence=evidence)
        except EcfitError:
            continue  # what this language cannot hold
        same = next((c for c in out if c.text == text), None)
        if same is None:
            out.append(Code(language.title, name, text))
        else:
            out[out.index(same)] = replace(same, label=f"{same.label}, {language.title}")
    out.append(Code("JSON", "json", json.dumps(approximation.to_dict(), ensure_ascii=False)))
    return out
