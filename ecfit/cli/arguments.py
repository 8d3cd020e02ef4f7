"""Arguments that several commands share, and what their texts mean."""

from typing import Annotated, Any, Literal

from cyclopts import Parameter

from ecfit.errors import EcfitError, refuse_ignored

Plugins = Annotated[
    tuple[str, ...],
    Parameter(name="--plugin", help="Python file or module that registers models; repeatable."),
]
Axes = Annotated[
    tuple[str, ...],
    Parameter(
        name="--axis", help="name=count, or name=low:high:count, in the order of the dimensions; repeatable."
    ),
]
GivenAxes = Annotated[
    tuple[str, ...],
    Parameter(name="--axis", help="name=count (0 to 1), name=low:high:count or name=x,x,...; repeatable."),
]
Options = Annotated[
    tuple[str, ...], Parameter(name="--option", help="A setting of the model, name=value; repeatable.")
]
Spacing = Literal["uniform", "gauss", "chebyshev", "texel-centre", "clamped"]


def options_of(pairs: tuple[str, ...]) -> dict[str, Any]:
    """name=value pairs; a value that reads as a number is one."""
    out: dict[str, Any] = {}
    for pair in _once(pairs):
        name, equals, value = pair.partition("=")
        if not equals or not name or not value:
            raise EcfitError(f"expected name=value, got '{pair}'")
        try:
            out[name] = float(value)
        except ValueError:
            out[name] = value
    return out


def axes_of(texts: tuple[str, ...], model: Any, quantity: Any, spacing: str) -> tuple[dict[str, Any], int]:
    """Axes of `--axis` arguments by name, and the number of entries of their grid."""
    import ecfit
    from ecfit.tables.tabulate import default_range

    axes: dict[str, Any] = {}
    total = 1
    for text in _once(texts):
        name, low, high, count = _axis(text)
        low, high = default_range(model, quantity, name, (low, high))
        axes[name] = ecfit.Axis.spaced(name, count, low, high, spacing)
        total *= count
    return axes, total


def given_axes(texts: tuple[str, ...], spacing: str | None) -> dict[str, Any]:
    """Axes of `ecfit import` by name."""
    import ecfit
    from ecfit.tables.given import full_range

    if all("," in text for text in texts):
        refuse_ignored("nodes that are listed have no spacing", {"spacing": spacing})
    axes: dict[str, Any] = {}
    for text in _once(texts):
        name, _, value = text.partition("=")
        if "," in value:
            axes[name] = ecfit.Axis.given(name, value.split(","))
        else:
            name, low, high, count = _axis(text)
            axes[name] = ecfit.Axis.spaced(name, count, *full_range(name, low, high), spacing or "uniform")
    return axes


def plain_axes(texts: tuple[str, ...], spacing: str | None) -> dict[str, Any]:
    """Axes of `ecfit export-table` by name: counts, whose range is that of the model, or whole axes."""
    import ecfit

    axes: dict[str, Any] = {}
    for text in _once(texts):
        name, low, high, count = _axis(text)
        if low is None or high is None:
            axes[name] = count
        else:
            axes[name] = ecfit.Axis.spaced(name, count, low, high, spacing or "uniform")
    return axes


def counts_of(texts: tuple[str, ...]) -> dict[str, int]:
    """Counts of `--axis name=count` by name."""
    out = {}
    for text in _once(texts):
        name, low, high, count = _axis(text)
        if low is not None or high is not None:
            raise EcfitError(f"a layout has its own ranges: give --axis {name}={count}")
        out[name] = count
    return out


def _once(pairs: tuple[str, ...]) -> tuple[str, ...]:
    """The same `name=...`. Raises `EcfitError` for a name that is there twice: one would be ignored."""
    names = [pair.partition("=")[0] for pair in pairs]
    for name in names:
        if names.count(name) > 1:
            raise EcfitError(f"'{name}' is given {names.count(name)} times: leave out all but one")
    return pairs


def _axis(text: str) -> tuple[str, float | None, float | None, int]:
    """(name, low, high, count) of `name=count` or `name=low:high:count`."""
    name, _, value = text.partition("=")
    parts = value.split(":")
    try:
        if name and len(parts) == 1:
            return name, None, None, int(parts[0])
        if name and len(parts) == 3:
            return name, float(parts[0]), float(parts[1]), int(parts[2])
    except ValueError:
        pass
    raise EcfitError(f"expected an axis name=count or name=low:high:count, got '{text}'")
