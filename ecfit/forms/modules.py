"""Forms that are a user's own Equinox module: its arrays are the coefficients, their values the start."""

import inspect
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from importlib import import_module
from typing import Any, TypeVar

import equinox as eqx
import numpy as np
from jax.flatten_util import ravel_pytree

from ecfit._jax import jax, jnp
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError, did_you_mean
from ecfit.forms.families import Form

# What makes a module: its class, or a function of its settings.
Factory = Callable[..., eqx.Module]

_MODULES: dict[str, Factory] = {}
# Modules of layers above this one, imported when they are asked for; nobody else may take their names.
_LAZY = {"learned-rational": "ecfit.fitting.learned", "written": "ecfit.forms.written"}
# Names of fits, which are names of files, are made of these.
_WORD = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,79}")

T = TypeVar("T", bound=Factory)


def register_form(name: str) -> Callable[[T], T]:
    """Decorator: make an Equinox module available under `name` to configs, and its fits to files.

    What is decorated is a class, or a function, that makes the module from keyword settings (words, numbers,
    lists and tables of these). See `ModuleForm` for what the module must do. Registering the same name again
    replaces it (convenient in a notebook), except for a name that ecfit ships. Raises `EcfitError` for such a
    name, for one that is no word, and for what makes no module.
    """
    if not isinstance(name, str) or not _WORD.fullmatch(name):
        raise EcfitError(
            f"register_form: a name is a word of letters, digits, '.', '_' and '-', got {name!r}"
        )

    def decorate(factory: T) -> T:
        if not callable(factory) or (inspect.isclass(factory) and not issubclass(factory, eqx.Module)):
            raise EcfitError(
                f"register_form('{name}') expects an equinox.Module class or a function that makes one, "
                f"got {factory!r}"
            )
        if name in _LAZY and getattr(factory, "__module__", "") != _LAZY[name]:
            raise EcfitError(f"the form name '{name}' is taken by ecfit; choose another")
        _MODULES[name] = factory
        return factory

    return decorate


def registered_forms() -> dict[str, Factory]:
    """All registered modules, by name."""
    for home in _LAZY.values():
        import_module(home)
    return dict(_MODULES)


def factory_of(name: str) -> Factory:
    """What makes the module of a registered name. Raises `EcfitError` for others."""
    if name in _LAZY:
        import_module(_LAZY[name])
    if name not in _MODULES:
        known = sorted({*_MODULES, *_LAZY})
        raise EcfitError(
            f"no module form '{name}' is registered: name the plugin with its @ecfit.register_form "
            f"(plugins = [...] in a study, or import it first); registered are {', '.join(known)}"
            f"{did_you_mean(name, known)}"
        )
    return _MODULES[name]


def make_module(name: str, settings: Mapping[str, Any] | None = None) -> eqx.Module:
    """The registered module `name` made with keyword settings. Raises `EcfitError` where that fails."""
    factory = factory_of(name)
    try:
        made = factory(**(settings or {}))
    except EcfitError as error:
        raise EcfitError(f"module form '{name}': {error}") from None
    except Exception as error:  # whatever the user's code raises is reported as its fault
        raise EcfitError(
            f"module form '{name}' cannot be made of the settings {dict(settings or {})!r}: "
            f"{type(error).__name__}: {error}"
        ) from error
    return checked(made, f"module form '{name}'")


def checked(module: Any, where: str) -> eqx.Module:
    """A module that can be called and has finite real arrays; raises `EcfitError` for anything else."""
    if not isinstance(module, eqx.Module) or not callable(module):
        raise EcfitError(f"{where} must be an equinox.Module with __call__, got {type(module).__name__}")
    for leaf in jax.tree_util.tree_leaves(eqx.filter(module, eqx.is_inexact_array)):
        if np.issubdtype(leaf.dtype, np.complexfloating):
            raise EcfitError(
                f"{where} has complex arrays: coefficients are real, use one array for each part"
            )
        if not np.all(np.isfinite(leaf)):
            raise EcfitError(f"{where} has an array that is not finite: it cannot be a start")
    return module


def _in_float64(module: eqx.Module) -> tuple[Any, Any]:
    arrays, rest = eqx.partition(module, eqx.is_inexact_array)
    return jax.tree_util.tree_map(lambda a: jnp.asarray(a, dtype=jnp.float64), arrays), rest


def coefficients_of(module: eqx.Module) -> np.ndarray:
    """The numbers of a module's inexact arrays, one after the other, float64."""
    leaves = jax.tree_util.tree_leaves(_in_float64(module)[0])
    return np.concatenate([np.zeros(0), *(np.asarray(leaf).ravel() for leaf in leaves)])


def with_coefficients(module: eqx.Module) -> Callable[[Any], Any]:
    """The function from coefficients (also traced ones) to the module that has them."""
    arrays, rest = _in_float64(module)
    unravel = ravel_pytree(arrays)[1]
    return lambda coefficients: eqx.combine(unravel(coefficients), rest)


def labels_of(module: eqx.Module) -> list[str]:
    """What each coefficient is, for people: "weight[2, 0]", or the module's own `labels()`."""
    own = getattr(module, "labels", None)
    if own is not None:
        return list(own())
    out = []
    for path, leaf in jax.tree_util.tree_leaves_with_path(eqx.filter(module, eqx.is_inexact_array)):
        name = jax.tree_util.keystr(path).lstrip(".")
        out += [f"{name}[{', '.join(map(str, i))}]" if i else name for i in np.ndindex(leaf.shape)]
    return out


def coordinates_of_module(module: eqx.Module, given: Sequence[str]) -> tuple[str, ...]:
    """The coordinates that a module is called with, out of the `given` ones in any view.

    Those that `__call__` names; where it takes any (`**coordinates`), its own `variables`, or else all given
    ones. Raises `EcfitError` where they do not stand for the given ones.
    """
    where = type(module).__name__
    parameters = list(inspect.signature(module.__call__).parameters.values())  # pyright: ignore
    if any(p.kind is p.VAR_KEYWORD for p in parameters):
        own = tuple(getattr(module, "variables", ()))
        if own:
            resolve(own, dict.fromkeys(given, 0.5))
        return own or tuple(given)
    if any(p.kind in (p.VAR_POSITIONAL, p.POSITIONAL_ONLY) for p in parameters):
        raise EcfitError(f"{where}.__call__ must take its coordinates by keyword: (self, mu, r)")
    optional = {p.name for p in parameters if p.default is not p.empty}
    for drop in (set(), optional):  # what has a default may be something else than a coordinate
        names = tuple(p.name for p in parameters if p.name not in drop)
        try:
            resolve(names, dict.fromkeys(given, 0.5))
        except EcfitError:
            continue
        return names
    raise EcfitError(
        f"{where} is a function of {', '.join(p.name for p in parameters) or 'nothing'}: "
        f"the table has {', '.join(given)}"
    )


def evaluated(module: Any, names: Sequence[str], points: Sequence[Any]) -> Any:
    """The module at points of one shape, one array a coordinate; raises `EcfitError` where it fails."""
    shape = points[0].shape
    try:
        value = jnp.asarray(module(**dict(zip(names, points, strict=True))))
    except EcfitError:
        raise
    except Exception as error:  # whatever the user's code raises is reported as its fault
        raise EcfitError(
            f"{type(module).__name__} failed at arrays {', '.join(names)} of shape {shape}: "
            f"{type(error).__name__}: {error}"
        ) from error
    if value.shape != shape:
        raise EcfitError(
            f"{type(module).__name__} returned the shape {value.shape} for coordinates of shape {shape}: "
            "__call__ must broadcast"
        )
    return value.astype(jnp.float64)


@dataclass(frozen=True)
class Record:
    """What a file holds of a module beside its coefficients: its registered name and settings."""

    name: str
    settings: Mapping[str, Any]

    def made(self, coefficients: np.ndarray) -> eqx.Module:
        """The module again. Raises `EcfitError` where its code makes another one now."""
        module = make_module(self.name, self.settings)
        count = coefficients_of(module).size
        if count != len(coefficients):
            raise EcfitError(
                f"module form '{self.name}' has {count} coefficients, {len(coefficients)} are given: "
                "its code is not what it was when it was fitted"
            )
        return with_coefficients(module)(jnp.asarray(coefficients, dtype=jnp.float64))


class ModuleForm(Form):
    """A form given by an Equinox module, which `ecfit.fit` fits by least squares.

    Its `__call__` takes the coordinates by keyword, arrays of one shape, and returns the values, in pure JAX:
    `(self, mu, r)` names those it wants, in any view; `(self, **coordinates)` gets the table's. Its inexact
    arrays are the coefficients, their values the start; everything else stays as it is. Optional:

        started(table): the module with a better start for a table (and arrays of other shapes, if need be);
        degree: a word for labels; the number of coefficients by default;
        denominator(**coordinates): what the module divides by, kept positive by the fit;
        expression(names): the value as an expression of coordinates named so: poles are then looked for;
        labels(): what each coefficient is, for people;
        smallest_denominator(domain): its `Minimum` over (low, high) of each coordinate: without it and an
            expression poles of the module are unknown, and nobody looks for them.

    Args:
        module: an instance, or the name of a registered one (`ecfit.register_form`).
        settings: of a registered name.

    Raises `EcfitError` for an unknown name and for what is no such module.
    """

    registered: str = eqx.field(static=True)
    settings: Mapping[str, Any] = eqx.field(static=True)
    given: eqx.Module | None

    def __init__(self, module: Any, settings: Mapping[str, Any] | None = None) -> None:
        self.registered = module if isinstance(module, str) else ""
        self.settings = dict(settings or {})
        # By name it is made when asked for: forms travel to worker processes, functions in modules do not.
        self.given = None if self.registered else checked(module, "a form")
        if self.registered:
            self.module()
        elif settings:
            raise EcfitError("settings belong to the name of a registered module, not to a module itself")

    def module(self) -> eqx.Module:
        """The module, with its own start."""
        return self.given if self.given is not None else make_module(self.registered, self.settings)

    @property
    def name(self) -> str:
        return self.registered or name_of_form(self.module()) or type(self.given).__name__

    @property
    def degree(self) -> str:
        return degree_of(self.module())

    def count(self, variables: int) -> int:
        return coefficients_of(self.module()).size

    def record(self, module: eqx.Module, names: Sequence[str]) -> Record | None:
        """How a file can name `module` (this form's, started and fitted); None where it cannot."""
        name = self.registered or name_of_form(module)
        if not name:
            return None
        coefficients = coefficients_of(module)
        points = [jnp.linspace(0.1, 0.9, 5)] * len(names)
        for settings in (self.settings, _static_settings(module, factory_of(name))):
            try:
                record = Record(name, json.loads(json.dumps(settings)))
                again = evaluated(record.made(coefficients), names, points)
                same = np.array_equal(again, evaluated(module, names, points), equal_nan=True)
            except (EcfitError, TypeError, ValueError):
                continue
            if same:
                return record
        return None


def name_of_form(module: eqx.Module) -> str:
    """The registered name of a module's class, or nothing."""
    return next((name for name, made in registered_forms().items() if made is type(module)), "")


def degree_of(module: eqx.Module) -> str:
    """The module's own word, or the number of its coefficients."""
    return str(getattr(module, "degree", None) or coefficients_of(module).size)


def _static_settings(module: eqx.Module, factory: Factory) -> dict[str, Any]:
    """Settings of a module made by its class directly: its fields that the class takes and are no arrays."""
    taken = inspect.signature(factory).parameters
    own = {f.name: getattr(module, f.name) for f in fields(module) if hasattr(module, f.name)}
    return {n: v for n, v in own.items() if n in taken and not any(map(eqx.is_array, jax.tree.leaves(v)))}
