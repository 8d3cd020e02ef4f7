"""Forms by name, as configs call them."""

from ecfit.errors import EcfitError, unknown
from ecfit.forms.families import Form, Polynomial, Rational
from ecfit.forms.specified import Selected, Structured

_FORMS: dict[str, type[Form]] = {
    "polynomial": Polynomial,
    "rational": Rational,
    "structured": Structured,
    "selected": Selected,
}


def forms() -> dict[str, type[Form]]:
    """All named families."""
    return dict(_FORMS)


def form(name: str, **settings: object) -> Form:
    """A form by name: `form("rational", degree=3)`. Raises `EcfitError` for unknown names and settings."""
    if name not in _FORMS:
        raise unknown("form", name, _FORMS)
    try:
        return _FORMS[name](**settings)  # type: ignore[arg-type]
    except TypeError:
        raise EcfitError(f"form '{name}' does not take {', '.join(settings)}") from None
