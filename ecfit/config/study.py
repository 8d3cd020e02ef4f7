"""The sections of a study file, and what is wrong with one. Nothing here imports JAX."""

import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from ecfit.config.toml import deepest_key, key_lines
from ecfit.contract import LOBES, QUANTITIES, TRANSPORTS
from ecfit.coordinates import MAPS, SPACINGS
from ecfit.errors import EcfitError, did_you_mean
from ecfit.files import read_text

# File names are made of these: plain words, no separators, nothing hidden.
Word = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,79}$")]


def _listed(value: Any) -> Any:
    """A single number stands for a list of one."""
    return [value] if isinstance(value, int) and not isinstance(value, bool) else value


def _setting(value: Any) -> Any:
    """A model's setting: a word or a number."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ValueError("expected a word or a number")
    return value


def _axis(value: Any) -> Any:
    """`r = 64` stands for `r = { count = 64 }`, and a list for its nodes."""
    if isinstance(value, int) and not isinstance(value, bool):
        return {"count": value}
    if isinstance(value, list):
        return {"nodes": value}
    if not isinstance(value, dict):
        raise ValueError("expected a count, a list of nodes, or a table such as { count = 64 }")
    return value


Degrees = Annotated[list[Annotated[int, Field(ge=0, le=20)]], Field(min_length=1), BeforeValidator(_listed)]

Counts = Annotated[list[Annotated[int, Field(ge=2, le=200)]], Field(min_length=1), BeforeValidator(_listed)]

# The norms of `ecfit.fitting.NORMS`, whose module imports JAX; a test holds them equal.
NormName = Literal[
    "least-squares",
    "l1",
    "l3",
    "l4",
    "l8",
    "minimax",
    "furnace-mean",
    "furnace-rms",
    "furnace-l4",
    "furnace-p99",
    "furnace-max",
]

Through = Literal["identity", "square", "sqrt", "fourth-power", "F0-to-ior"]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class AxisConfig(_Section):
    """One axis: a count with a spacing, or nodes."""

    count: Annotated[int, Field(ge=2, le=100_000, description="number of nodes")] | None = None
    nodes: Annotated[list[float], Field(min_length=2, description="increasing coordinates")] | None = None
    low: Annotated[float | None, Field(description="lower end; the full range by default")] = None
    high: Annotated[float | None, Field(description="upper end; the full range by default")] = None
    spacing: Annotated[
        Literal["uniform", "gauss", "chebyshev", "texel-centre", "clamped"], Field(description="of nodes")
    ] = "uniform"
    through: Annotated[Through, Field(description="spaced in t, where the coordinate is map(t)")] = "identity"

    @model_validator(mode="after")
    def _one_of(self) -> "AxisConfig":
        if (self.count is None) == (self.nodes is None):
            raise ValueError("give either count or nodes")
        return self


class TableConfig(_Section):
    """One table: a quantity of a model on a grid, integrated here or read from somebody's file."""

    name: Annotated[Word, Field(description="what fits and reports call it")]
    model: Annotated[
        str,
        Field(min_length=1, description="a registered model, or one from plugins; of a file also unknown"),
    ]
    options: Annotated[
        dict[str, Annotated[Any, BeforeValidator(_setting)]], Field(description="the model's settings")
    ] = {}
    file: Annotated[
        str | None, Field(min_length=1, description="CSV, NPY or EXR file, relative to the config")
    ] = None
    stored: Annotated[Literal["E", "1-E"] | None, Field(description="what the file holds")] = None
    scale: Annotated[
        float | None, Field(gt=0.0, description="the stored number that stands for 1: 65535 for 16 bits")
    ] = None
    order: Annotated[
        list[str] | None,
        Field(description="axes as the file stores them, fastest last; -mu: from the last node to the first"),
    ] = None
    channel: Annotated[str | None, Field(description="of the file: R, G, ... or a column's name")] = None
    quantity: Annotated[
        Literal[
            "directional-albedo",
            "average-albedo",
            "schlick-a",
            "schlick-b",
            "f82-moment",
            "average-fresnel",
            "zonal-moment",
            "multiple-bounces",
            "ltc-scale",
            "fresnel",
            "brdf",
        ],
        Field(description="what is integrated"),
    ] = "directional-albedo"
    quantity_options: Annotated[
        dict[str, int], Field(description="settings of the quantity, such as exponent or degree")
    ] = {}
    lobe: Annotated[Literal["all", "reflection", "transmission"], Field(description="part of the BSDF")] = (
        "all"
    )
    transport: Annotated[Literal["energy", "radiance"], Field(description="of the transmitted lobe")] = (
        "energy"
    )
    axes: Annotated[
        dict[str, Annotated[AxisConfig, BeforeValidator(_axis)]],
        Field(min_length=1, description="name = count, or nodes, or a table; in the order of the dimensions"),
    ]
    tolerance: Annotated[
        float | None,
        Field(gt=0.0, lt=1.0, description="absolute error of every entry, 1e-7 by default; not of a file"),
    ] = None

    @model_validator(mode="before")
    @classmethod
    def _defaults(cls, data: Any) -> Any:
        """What is integrated has a tolerance; what is read has a storage, and its model may be unknown."""
        if not isinstance(data, dict):
            return data
        if "file" in data:
            return {"model": "unknown", "stored": "E", "scale": 1.0, **data}
        return {"tolerance": 1e-7, **data}

    @model_validator(mode="after")
    def _one_source(self) -> "TableConfig":
        if self.file is not None:
            if self.tolerance is not None:
                raise ValueError("a tolerance belongs to what is integrated: leave it out beside file")
            return self
        for key in ("stored", "scale", "order", "channel"):
            if getattr(self, key) is not None:
                raise ValueError(f"{key} says how a file is read: give file as well, or leave it out")
        return self


Rows = list[list[float]]


class TermsConfig(_Section):
    """Exponents of a structured form: one row a term, one number a feature."""

    numerators: Annotated[list[Rows], Field(min_length=1, description="rows of each ratio's numerator")]
    denominator: Annotated[
        Rows, Field(min_length=1, description="rows of Q; the first has the coefficient 1")
    ]


class PowersConfig(_Section):
    """Bounds of the terms that a selection may choose from."""

    highest: Annotated[dict[str, float], Field(min_length=1, description="feature = highest exponent")]
    step: Annotated[float, Field(gt=0.0, description="of the exponents of alpha, mu and g")] = 1.0
    lowest_order: Annotated[float, Field(ge=0.0, description="at the corner alpha = mu = 0")] = 0.0
    highest_order: Annotated[float, Field(ge=0.0, description="at the corner alpha = mu = 0")] = 64.0
    factors: Annotated[int, Field(ge=1, description="features in one term")] = 3
    total: Annotated[float, Field(ge=0.0, description="sum of a term's exponents")] = 64.0


class WithinConfig(_Section):
    """Bounds of all terms of a selected form."""

    numerators: Annotated[list[PowersConfig], Field(min_length=1, description="of each ratio")]
    denominator: Annotated[PowersConfig, Field(description="of Q")]


# Which keys belong to which form, beside those of every fit; those of _OPTIONAL_KEYS may be left out.
_FORM_KEYS = {
    "polynomial": ("degree",),
    "rational": ("degree", "numerator", "denominator", "guarded"),
    "structured": ("head", "features", "terms", "start", "charted"),
    "selected": ("head", "features", "within", "budget", "rounds", "seeds", "price", "rounding"),
    "module": ("module", "module_settings"),
    "composed": ("text", "parts"),
}
_OPTIONAL_KEYS = (
    "degree", "numerator", "denominator", "guarded", "start", "charted", "rounds", "seeds", "price",
    "rounding",
    "module_settings",
)  # fmt: skip
# How a fit is made: keys of which a module takes some, as it is fitted by least squares, and a composed form
# none, as it is not fitted.
_HOW = ("norm", "digits", "strength", "margin", "ridge", "weights", "monotone", "lower_bound")
_NOT_OF = {
    "module": (
        ("norm", "strength", "margin", "ridge", "monotone", "lower_bound"),
        "it is fitted by least squares",
    ),
    "composed": (_HOW, "its parts are fitted, it is not"),
}


def _written(key: str) -> str:
    """A field's key in the file."""
    return FitsConfig.model_fields[key].alias or key


class FitsConfig(_Section):
    """Fits of one form, crossed over tables and degrees."""

    tables: Annotated[list[str], Field(min_length=1, description="names of tables")]
    form: Annotated[
        Literal["polynomial", "rational", "structured", "selected", "module", "composed"],
        Field(description="family of functions"),
    ]
    name: Annotated[
        Word | None, Field(description="of the fit; made of table, form and degree by default")
    ] = None
    degree: Annotated[Degrees | None, Field(description="total degree, or a list")] = None
    numerator: Annotated[Degrees | None, Field(description="with denominator, instead of degree")] = None
    denominator: Annotated[Degrees | None, Field(description="with numerator, instead of degree")] = None
    guarded: Annotated[bool, Field(description="rational: false lets the optimum have poles")] = True
    head: Annotated[
        str | dict[str, Any] | None, Field(description="structured, selected: a name, or a head's fields")
    ] = None
    features: Annotated[list[str] | None, Field(description="structured, selected: names of features")] = None
    terms: Annotated[TermsConfig | None, Field(description="structured: exponents of the features")] = None
    start: Annotated[list[float] | None, Field(description="structured: coefficients to begin from")] = None
    charted: Annotated[
        bool, Field(description="structured: evaluated in alpha / rho, mu / rho, rho: for half precision")
    ] = False
    within: Annotated[WithinConfig | None, Field(description="selected: bounds of the terms")] = None
    budget: Annotated[Counts | None, Field(description="selected: number of coefficients, or a list")] = None
    rounds: Annotated[int, Field(ge=0, le=100_000, description="selected: exchanges tried")] = 100
    seeds: Annotated[
        int, Field(ge=1, le=1000, description="selected: searches, the best of which is kept")
    ] = 1
    price: Annotated[
        float,
        Field(ge=0.0, le=1.0, description="selected: part of the error that an operation less is worth"),
    ] = 0.0
    rounding: Annotated[
        float,
        Field(ge=0.0, lt=1.0, description="selected: what a form may lose in single precision; 0: no limit"),
    ] = 0.0
    module: Annotated[
        str | None, Field(min_length=1, description="module: a registered name, or one from plugins")
    ] = None
    # `settings` in the file; the name here is taken by the method.
    module_settings: Annotated[
        dict[str, Any] | None, Field(alias="settings", description="module: what it is made with")
    ] = None
    text: Annotated[
        str | None, Field(min_length=1, description="composed: the value in the names of its parts")
    ] = None
    parts: Annotated[
        dict[str, str] | None, Field(min_length=1, description="composed: name in the text = name of a fit")
    ] = None
    norm: Annotated[NormName, Field(description="what best means")] = "least-squares"
    digits: Annotated[int | None, Field(ge=3, le=17, description="coefficients rounded to these")] = None
    strength: Annotated[float, Field(ge=0.0, description="weight of what keeps Q > 0 and E <= 1")] = 1.0
    margin: Annotated[float, Field(ge=0.0, description="how far within the form's limits to stay")] = 0.0
    ridge: Annotated[float, Field(ge=0.0, description="weight of coefficients' sizes; no maximum norm")] = 0.0
    weights: Annotated[
        dict[str, float] | None,
        Field(min_length=1, description="coordinate = power: entries weigh coordinate^power"),
    ] = None
    monotone: Annotated[
        dict[str, Literal[1, -1]] | None,
        Field(min_length=1, description="coordinate = 1 (does not fall) or -1 (does not rise)"),
    ] = None

    lower_bound: Annotated[
        bool, Field(description="also compute the least possible largest error of the form")
    ] = False

    @model_validator(mode="after")
    def _keys(self) -> "FitsConfig":
        needs = _FORM_KEYS[self.form]
        for key in sorted(set().union(*_FORM_KEYS.values()) - set(needs)):
            if getattr(self, key) != type(self).model_fields[key].default:
                raise ValueError(f"{_written(key)} does not belong to the form '{self.form}'")
        for key in needs:
            if key not in _OPTIONAL_KEYS and getattr(self, key) is None:
                raise ValueError(f"the form '{self.form}' needs {key}")
        foreign, why = _NOT_OF.get(self.form, ((), ""))
        for key in foreign:
            if getattr(self, key) != type(self).model_fields[key].default:
                raise ValueError(f"{key} does not belong to the form '{self.form}': {why}")
        if self.form == "composed" and self.name is None:
            raise ValueError("a composed form needs a name")
        if self.name is not None and (len(self.tables) > 1 or len(self.settings()) > 1):
            raise ValueError("a name is for one fit: give one table and one degree or budget")
        return self

    @model_validator(mode="after")
    def _degrees(self) -> "FitsConfig":
        if self.form not in ("polynomial", "rational"):
            return self
        apart = self.numerator is not None and self.denominator is not None
        if (self.degree is None) != apart or (self.numerator is None) != (self.denominator is None):
            raise ValueError("give either degree, or both numerator and denominator")
        if apart and self.form != "rational":
            raise ValueError("numerator and denominator belong to the form 'rational'")
        if not self.guarded and self.form != "rational":
            raise ValueError("guarded = false belongs to the form 'rational'")
        if 0 in (self.degree or []):
            raise ValueError("degree must be 1 or more")
        return self

    def settings(self) -> list[dict[str, Any]]:
        """The form's settings of each fit, in the order of the file."""
        if self.module is not None:
            return [{"module": self.module, "settings": self.module_settings or {}}]
        if self.parts is not None:
            return [{"text": self.text, "parts": self.parts}]
        if self.terms is not None:
            terms = {"numerators": self.terms.numerators, "denominator": self.terms.denominator}
            # Left out where it is the default: the keys of fits hash these.
            rest = {"charted": True} if self.charted else {}
            return [
                {"head": self.head, "features": self.features, **terms, "start": self.start or (), **rest}
            ]
        if self.within is not None:
            bounds = {
                "numerators": [n.model_dump() for n in self.within.numerators],
                "denominator": self.within.denominator.model_dump(),
            }
            rest = {
                "rounds": self.rounds, "seeds": self.seeds, "price": self.price, "rounding": self.rounding,
                "budgets": self.budget,
            }  # fmt: skip
            return [
                {"head": self.head, "features": self.features, **bounds, "budget": b, **rest}
                for b in self.budget or []
            ]
        return self._degree_settings()

    def norm_settings(self) -> dict[str, Any]:
        """How each is fitted, where that is not plain least squares."""
        usual = {key: type(self).model_fields[key].default for key in _HOW}
        return {key: getattr(self, key) for key in _HOW if getattr(self, key) != usual[key]}

    def _degree_settings(self) -> list[dict[str, Any]]:
        rest: dict[str, int | bool] = {} if self.guarded else {"guarded": False}
        if self.degree is not None:
            return [{"degree": d, **rest} for d in self.degree]
        return [
            {"numerator": n, "denominator": d, **rest}
            for n in self.numerator or []
            for d in self.denominator or []
            if n or d
        ]


class LookupConfig(_Section):
    """A small table with multilinear interpolation, over the domain of the table that it is judged on."""

    counts: Annotated[
        dict[str, Annotated[int, Field(ge=2, le=4096)]],
        Field(min_length=1, description="nodes of each coordinate, both ends included"),
    ]
    through: Annotated[
        dict[str, Through], Field(description="maps: nodes equidistant in t, where the coordinate is map(t)")
    ] = {}

    @model_validator(mode="after")
    def _known(self) -> "LookupConfig":
        for name in self.through:
            if name not in self.counts:
                raise ValueError(f"through names '{name}', which is not in counts")
        return self


class CompareConfig(_Section):
    """Published and shipped fits and look-up tables to judge on a table beside those of the study."""

    tables: Annotated[list[str], Field(min_length=1, description="names of tables")]
    published: Annotated[list[str], Field(min_length=1, description="names of published fits")] | None = None
    shipped: Annotated[list[str], Field(min_length=1, description="names of shipped fits")] | None = None
    lookups: Annotated[list[LookupConfig], Field(min_length=1, description="small tables")] | None = None

    @model_validator(mode="after")
    def _something(self) -> "CompareConfig":
        if not (self.published or self.shipped or self.lookups):
            raise ValueError("give published, shipped or lookups, or several of them")
        return self


class ReportConfig(_Section):
    """What the report writes."""

    figures: Annotated[list[Literal["svg", "png"]], Field(description="formats of the figure files")] = [
        "svg",
        "png",
    ]


class StudyConfig(_Section):
    """A whole study."""

    name: Annotated[Word, Field(description="name of its folder in results")]
    plugins: Annotated[list[str], Field(description="Python files or modules that register models")] = []
    tables: Annotated[list[TableConfig], Field(min_length=1, description="tables to compute")]
    fits: Annotated[list[FitsConfig], Field(description="fits to make")] = []
    compare: Annotated[list[CompareConfig], Field(description="what to judge beside the fits")] = []
    report: Annotated[ReportConfig, Field(description="what the report writes")] = ReportConfig()


# The literals above repeat names that live elsewhere; a test holds them equal.
CHOICES = {
    ("AxisConfig", "spacing"): set(SPACINGS) - {"given"},
    ("AxisConfig", "through"): set(MAPS),
    ("TableConfig", "quantity"): set(QUANTITIES),
    ("TableConfig", "lobe"): set(LOBES),
    ("TableConfig", "transport"): set(TRANSPORTS),
}


def read_config(path: str | Path) -> StudyConfig:
    """Read and check a study file.

    Raises `EcfitError` with one line a fault: file, line, key, value, what is allowed, and what may have
    been meant.
    """
    return read_checked(path, StudyConfig, _cross_check, "configs/quick.toml")


# Characters of a study file: thirty times as many as our longest.
_LONGEST = 1_000_000
_MOST_FAULTS = 50
# Parts of a key: a study has five levels.
_DEEPEST = 50

# Where a fault is, and what it is.
Fault = tuple[tuple[str | int, ...], str]
Sections = TypeVar("Sections", bound=BaseModel)


def read_checked(
    path: str | Path, kind: type[Sections], cross_check: Callable[[Sections], list[Fault]], example: str
) -> Sections:
    """Read a TOML file as sections of a kind, with the faults that `cross_check` finds between them.

    Raises `EcfitError` as `read_config` does.
    """
    path = Path(path)
    text = read_text(path)
    if len(text) > _LONGEST:
        raise EcfitError(
            f"{path}: {len(text)} characters, a study has at most {_LONGEST}: is this another file?"
        )
    try:
        if deepest_key(text) > _DEEPEST:
            raise RecursionError
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise EcfitError(f"{path}: not valid TOML: {error}") from None
    except ValueError:  # Python reads no longer ones
        raise EcfitError(f"{path}: not valid TOML: a whole number of thousands of digits") from None
    except RecursionError:
        raise EcfitError(f"{path}: not valid TOML: nested too deeply") from None
    if not data:
        raise EcfitError(f"{path}: the file is empty; see {example} for an example")
    try:
        config = kind.model_validate(data)
    except ValidationError as error:
        raise EcfitError(_first(_messages(path, text, error, kind))) from None
    faults = cross_check(config)
    if faults:
        lines = key_lines(text)
        raise EcfitError(_first(f"{_where(path, lines, loc)}: {message}" for loc, message in faults))
    return config


def _first(messages: Iterable[str]) -> str:
    """As many lines as somebody reads."""
    told = list(islice(messages, _MOST_FAULTS + 1))
    more = ["... and more faults than these"] if len(told) > _MOST_FAULTS else []
    return "\n".join(told[:_MOST_FAULTS] + more)


def _cross_check(config: StudyConfig) -> list[Fault]:
    """Faults between sections: repeated table names, fits of tables that do not exist."""
    faults: list[Fault] = []
    names = [t.name for t in config.tables]
    for i, name in enumerate(names):
        if name in names[:i]:
            faults.append((("tables", i, "name"), f"the table name '{name}' is used twice"))
    for section in ("fits", "compare"):
        for i, item in enumerate(getattr(config, section)):
            for name in item.tables:
                if name not in names:
                    message = f"no table '{name}': expected one of {', '.join(names)}"
                    faults.append(((section, i, "tables"), message + did_you_mean(name, names)))
    return faults


def _where(path: Path, lines: Mapping[tuple[str | int, ...], int], location: Sequence[str | int]) -> str:
    """`file:line: key` for the deepest part of a location that the file holds."""
    place = tuple(location)
    known = place
    while known and known not in lines:
        known = known[:-1]
    line = f":{lines[known]}" if known else ""
    key = ".".join(str(p) for p in place if isinstance(p, str)) or "(file)"
    return f"{path}{line}: {key}"


def _messages(path: Path, text: str, error: ValidationError, root: type[BaseModel]) -> Iterator[str]:
    lines = key_lines(text)
    # A missing key is often a misspelt one: the misspelling, which says so, comes first.
    for fault in sorted(error.errors(), key=lambda f: f["type"] == "missing"):
        location = fault["loc"]
        if fault["type"] == "missing":
            message = "this key is missing"
        elif fault["type"] == "extra_forbidden":
            valid = _keys_at(root, location[:-1])
            message = (
                f"unknown key: expected one of {', '.join(valid)}{did_you_mean(str(location[-1]), valid)}"
            )
        else:
            value = fault.get("input")
            shown = f"{_short(repr(value))}: " if isinstance(value, str | int | float) else ""
            message = shown + _plain(fault)
        yield f"{_where(path, lines, location)}: {message}"


def _short(text: str) -> str:
    return text if len(text) <= 200 else f"{text[:200]}..."


def _plain(fault: Any) -> str:
    """What is allowed, from a pydantic fault."""
    context = fault.get("ctx", {})
    if fault["type"] == "literal_error":
        valid = [str(v).strip("'") for v in str(context["expected"]).replace(" or ", ", ").split(", ")]
        return f"expected one of {', '.join(valid)}{did_you_mean(str(fault.get('input')), valid)}"
    if fault["type"] == "string_pattern_mismatch":
        return "expected a plain word of letters, digits, '.', '_' and '-' (at most 80)"
    message = fault["msg"].removeprefix("Value error, ").removeprefix("Input ").replace("dictionary", "table")
    message = message.split(" or instance of")[0]
    return message[0].lower() + message[1:]


def _keys_at(root: type[BaseModel], location: Sequence[str | int]) -> list[str]:
    """Allowed keys of the section of `root` at a location."""
    section: Any = root
    for part in location:
        # Indices, and names of a dictionary's entries, lead to no other section.
        if isinstance(part, str) and part in section.model_fields:
            section = _section_in(section.model_fields[part].annotation) or section
    return [field.alias or name for name, field in section.model_fields.items()]


def _section_in(annotation: Any) -> Any:
    """The config class somewhere inside a type such as `list[TableConfig]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_section_in(inner) for inner in get_args(annotation))
    return next((section for section in found if section is not None), None)
