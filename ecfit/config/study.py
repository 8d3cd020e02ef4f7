"""The sections of a study file, and what is wrong with one. Nothing here imports JAX."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from ecfit.config.toml import key_lines
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


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class AxisConfig(_Section):
    """One axis: a count with a spacing, or nodes."""

    count: Annotated[int, Field(ge=2, le=100_000, description="number of nodes")] | None = None
    nodes: Annotated[list[float], Field(min_length=2, description="increasing coordinates")] | None = None
    low: Annotated[float | None, Field(description="lower end; the full range by default")] = None
    high: Annotated[float | None, Field(description="upper end; the full range by default")] = None
    spacing: Annotated[Literal["uniform", "gauss", "chebyshev", "clamped"], Field(description="of nodes")] = (
        "uniform"
    )
    through: Annotated[
        Literal["identity", "square", "sqrt", "fourth-power", "F0-to-ior"],
        Field(description="spaced in t, where the coordinate is map(t)"),
    ] = "identity"

    @model_validator(mode="after")
    def _one_of(self) -> "AxisConfig":
        if (self.count is None) == (self.nodes is None):
            raise ValueError("give either count or nodes")
        return self


class TableConfig(_Section):
    """One table: a quantity of a model on a grid."""

    name: Annotated[Word, Field(description="what fits and reports call it")]
    model: Annotated[str, Field(min_length=1, description="a registered model, or one from plugins")]
    options: Annotated[
        dict[str, Annotated[Any, BeforeValidator(_setting)]], Field(description="the model's settings")
    ] = {}
    quantity: Annotated[
        Literal[
            "directional-albedo",
            "average-albedo",
            "schlick-a",
            "schlick-b",
            "f82-moment",
            "average-fresnel",
        ],
        Field(description="what is integrated"),
    ] = "directional-albedo"
    quantity_options: Annotated[
        dict[str, int], Field(description="settings of the quantity, such as exponent")
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
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0, description="absolute error of every entry")] = 1e-7


class FitsConfig(_Section):
    """Fits of one form, crossed over tables and degrees."""

    tables: Annotated[list[str], Field(min_length=1, description="names of tables")]
    form: Annotated[Literal["polynomial", "rational"], Field(description="family of functions")]
    degree: Annotated[Degrees | None, Field(description="total degree, or a list")] = None
    numerator: Annotated[Degrees | None, Field(description="with denominator, instead of degree")] = None
    denominator: Annotated[Degrees | None, Field(description="with numerator, instead of degree")] = None
    guarded: Annotated[bool, Field(description="rational: false lets the optimum have poles")] = True

    @model_validator(mode="after")
    def _degrees(self) -> "FitsConfig":
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

    def settings(self) -> list[dict[str, int | bool]]:
        """The form's settings of each fit, in the order of the file."""
        rest: dict[str, int | bool] = {} if self.guarded else {"guarded": False}
        if self.degree is not None:
            return [{"degree": d, **rest} for d in self.degree]
        return [
            {"numerator": n, "denominator": d, **rest}
            for n in self.numerator or []
            for d in self.denominator or []
            if n or d
        ]


class CompareConfig(_Section):
    """Published fits to judge on a table beside ours."""

    tables: Annotated[list[str], Field(min_length=1, description="names of tables")]
    published: Annotated[list[str], Field(min_length=1, description="names of published fits")]


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
    compare: Annotated[list[CompareConfig], Field(description="published fits to judge")] = []
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
    path = Path(path)
    text = read_text(path)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise EcfitError(f"{path}: not valid TOML: {error}") from None
    except RecursionError:
        raise EcfitError(f"{path}: not valid TOML: nested too deeply") from None
    if not data:
        raise EcfitError(f"{path}: the file is empty; see configs/quick.toml for an example")
    try:
        config = StudyConfig.model_validate(data)
    except ValidationError as error:
        raise EcfitError("\n".join(_messages(path, text, error))) from None
    faults = _cross_check(config)
    if faults:
        lines = key_lines(text)
        raise EcfitError("\n".join(f"{_where(path, lines, loc)}: {message}" for loc, message in faults))
    return config


def _cross_check(config: StudyConfig) -> list[tuple[tuple[str | int, ...], str]]:
    """Faults between sections: repeated table names, fits of tables that do not exist."""
    faults: list[tuple[tuple[str | int, ...], str]] = []
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


def _messages(path: Path, text: str, error: ValidationError) -> list[str]:
    lines = key_lines(text)
    out: list[str] = []
    # A missing key is often a misspelt one: the misspelling, which says so, comes first.
    for fault in sorted(error.errors(), key=lambda f: f["type"] == "missing"):
        location = fault["loc"]
        if fault["type"] == "missing":
            message = "this key is missing"
        elif fault["type"] == "extra_forbidden":
            valid = _keys_at(location[:-1])
            message = (
                f"unknown key: expected one of {', '.join(valid)}{did_you_mean(str(location[-1]), valid)}"
            )
        else:
            value = fault.get("input")
            shown = f"{value!r}: " if isinstance(value, str | int | float) else ""
            message = shown + _plain(fault)
        out.append(f"{_where(path, lines, location)}: {message}")
    return out


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


def _keys_at(location: Sequence[str | int]) -> list[str]:
    """Allowed keys of the section at a location."""
    section: Any = StudyConfig
    for part in location:
        # Indices, and names of a dictionary's entries, lead to no other section.
        if isinstance(part, str) and part in section.model_fields:
            section = _section_in(section.model_fields[part].annotation) or section
    return list(section.model_fields)


def _section_in(annotation: Any) -> Any:
    """The config class somewhere inside a type such as `list[TableConfig]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_section_in(inner) for inner in get_args(annotation))
    return next((section for section in found if section is not None), None)
