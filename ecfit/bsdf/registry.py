"""Models by name, so that a config can ask for them, a user's own among them."""

import inspect
from collections.abc import Callable
from importlib import import_module
from typing import TypeVar

from ecfit.bsdf.base import BSDF
from ecfit.errors import EcfitError, did_you_mean, unknown

_MODELS: dict[str, type[BSDF]] = {}
# Models of layers above this one, imported when they are asked for.
_LAZY = {"glossy": "ecfit.compensation", "enterprise": "ecfit.enterprise"}

T = TypeVar("T", bound=type[BSDF])


def register(name: str) -> Callable[[T], T]:
    """Class decorator: make a model available under `name` to `ecfit.model` and to configs.

    Registering the same name again replaces the model (convenient in a notebook), except for a name
    that ecfit ships. Raises `EcfitError` for such a name, and for what is no subclass of `ecfit.BSDF`.
    """

    def decorate(cls: T) -> T:
        if not (inspect.isclass(cls) and issubclass(cls, BSDF)):
            raise EcfitError(f"register('{name}') expects a subclass of ecfit.BSDF, got {cls!r}")
        old = _MODELS.get(name)
        if old is not None and old.__module__.startswith("ecfit.") and cls.__qualname__ != old.__qualname__:
            raise EcfitError(f"the model name '{name}' is taken by ecfit; choose another")
        _MODELS[name] = cls
        return cls

    return decorate


def models() -> dict[str, type[BSDF]]:
    """All registered models: name -> class. Plugins are among them once they are imported."""
    for module in _LAZY.values():
        import_module(module)
    return dict(_MODELS)


def model(name: str, /, **settings: object) -> BSDF:
    """An instance of the registered model `name`.

    `settings` are its options (words) and parameters (numbers). Raises `EcfitError` for an unknown
    model, setting or option value, and for a parameter outside its range.
    """
    if name not in _MODELS and name not in models():
        said = unknown("model", name, _MODELS)
        raise EcfitError(f"{said} (one of your own: --plugin FILE, or plugins = [FILE] in a config)")
    cls = _MODELS[name]
    ranges, choices = cls.parameter_ranges(), cls.option_choices()
    for key, value in settings.items():
        valid = [*choices, *ranges]
        if key not in valid:
            listed = ", ".join(sorted(valid)) or "none"
            raise EcfitError(
                f"model '{name}' has no setting '{key}': expected one of {listed}{did_you_mean(key, valid)}"
            )
        if key in ranges and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise EcfitError(f"parameter '{key}' of model '{name}' must be a number, got {value!r}")
    made = cls(**settings)  # type: ignore[arg-type]
    for key in ranges:
        if key in settings:
            made.check_range(key, float(settings[key]), float(settings[key]))  # type: ignore[arg-type]
    return made


def name_of(bsdf: BSDF) -> str:
    """The registered name of a model's class, or the class's own name."""
    for name, cls in _MODELS.items():
        if type(bsdf) is cls:
            return name
    return type(bsdf).__name__


def as_model(bsdf: BSDF | type[BSDF] | str) -> BSDF:
    """A model from itself, its class (with its defaults) or its registered name.

    Raises `EcfitError` for an unknown name and for anything else.
    """
    if isinstance(bsdf, BSDF):
        return bsdf
    if isinstance(bsdf, str):
        return model(bsdf)
    if inspect.isclass(bsdf) and issubclass(bsdf, BSDF):
        return bsdf()
    raise EcfitError(f"expected a BSDF or the name of a registered one, got {type(bsdf).__name__}")
