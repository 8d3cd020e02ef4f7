"""Forms that are put together from fits that a study names; nothing is fitted."""

import re
from collections.abc import Mapping

import equinox as eqx

from ecfit.errors import EcfitError
from ecfit.expressions import parse
from ecfit.forms.families import Form


class Composition(Form):
    """A formula of other fits, such as "E1 * E_spec".

    Args:
        text: the value in the names of the parts.
        parts: name in the text -> name of a fit of the same study.

    Raises `EcfitError` for a text that cannot be read and for names that are no plain words.
    """

    text: str = eqx.field(static=True)
    parts: tuple[tuple[str, str], ...] = eqx.field(static=True)

    def __init__(self, text: str, parts: Mapping[str, str]) -> None:
        for name in parts:
            if not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name):
                raise EcfitError(f"'{name}' is no name of a part: use letters, digits and _")
        if not parts:
            raise EcfitError("a composed form needs parts: name in the text = name of a fit of the study")
        parse(text, tuple(parts))
        self.text, self.parts = text, tuple(parts.items())

    @property
    def name(self) -> str:
        return "composed"

    @property
    def degree(self) -> str:
        return "+".join(fit for _, fit in self.parts)

    def count(self, variables: int) -> int:
        return 0  # none of its own
