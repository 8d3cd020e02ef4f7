"""Forms by name, as configs call them."""

import inspect

from ecfit.errors import EcfitError, did_you_mean, unknown
from ecfit.forms.composition import Composition
from ecfit.forms.families import Form, Polynomial, Rational
from ecfit.forms.modules import ModuleForm
from ecfit.forms.specified import Selected, Structured

_FORMS: dict[str, type[Form]] = {
    "polynomial": Polynomial,
    "rational": Rational,
    "structured": Structured,
    "selected": Selected,
    "module": ModuleForm,
    "composed": Composition,
}


def forms() -> dict[str, type[Form]]:
    """All named families."""
    return dict(_FORMS)


def form(name: str, **settings: object) -> Form:
    """A form by name: `form("rational", degree=3)`. Raises `EcfitError` for unknown names and settings."""
    if name not in _FORMS:
        raise unknown("form", name, _FORMS)
    takes = inspect.signature(_FORMS[name].__init__).parameters
    for setting in settings:
        if setting not in takes:
            known = list(takes)[1:]
            raise EcfitError(
                f"form '{name}' does not take {setting}: expected one of {', '.join(known)}"
                f"{did_you_mean(setting, known)}"
            )
    try:
        return _FORMS[name](**settings)  # type: ignore[arg-type]
    except TypeError as error:
        raise EcfitError(f"form '{name}': malformed settings {', '.join(settings)} ({error})") from None
