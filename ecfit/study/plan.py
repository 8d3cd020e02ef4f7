"""From a config to what has to be computed: every name resolved, every domain checked, nothing computed."""

import hashlib
import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ecfit.approximation import Approximation, published, shipped
from ecfit.approximation.tables import lookup_request
from ecfit.bsdf import model
from ecfit.config import AxisConfig, CompareConfig, StudyConfig, TableConfig
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError, unknown
from ecfit.fitting.fit import check_asked, check_data
from ecfit.forms import Composition, Form, Selected, form
from ecfit.forms.modules import factory_of
from ecfit.quantities import quantity
from ecfit.study.plugins import Plugin, load_plugins
from ecfit.tables import Given, Request, claim, read_table
from ecfit.tables.given import full_range
from ecfit.tables.tabulate import default_range, source_hash

# Raise this when a change moves the coefficients of fits: it is part of every fit's key.
FITTING_VERSION = 4
# The same for what searches find.
SEARCH_VERSION = 1

# Labels hold names that configs and plugins give to heads and forms: no separators, no control characters.
_FILE_NAME = re.compile(r"[\w .+-]{1,200}")


@dataclass(frozen=True)
class PlannedFit:
    """One form on one table. `label` names its file: table-form-degree, or the name that the config gives.

    `settings` are those of `ecfit.fit` (norm, digits, ...), `name` what reports call the fit, `searches` the
    keys of the searches that choose its terms.
    """

    table: str
    form: Form
    label: str
    key: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    name: str | None = None
    searches: tuple[str, ...] = ()


@dataclass(frozen=True)
class PlannedSearch:
    """One search of terms for a table. All budgets of a form share its searches, one a seed."""

    table: str
    form: Selected
    seed: int
    key: str

    @property
    def label(self) -> str:
        """For messages and timings."""
        return f"{self.table}, {self.form.name}, seed {self.seed}"


@dataclass(frozen=True)
class Plan:
    """A checked study: requests (or given tables) by name, fits and searches in order.

    What is judged beside our fits is by table: published fits, and requests of look-up tables. `plugins` are
    the user's modules, which workers load too.
    """

    config: StudyConfig
    requests: dict[str, Request | Given]
    fits: tuple[PlannedFit, ...]
    searches: tuple[PlannedSearch, ...]
    compare: dict[str, tuple[Approximation, ...]]
    lookups: dict[str, tuple[Request, ...]]
    plugins: tuple[Plugin, ...] = ()


def _axis(name: str, axis: AxisConfig, full: Callable[[], tuple[float, float]]) -> Axis:
    """The axis of a config; `full` is its range where it has a count, and may refuse."""
    if axis.nodes is not None:
        return Axis.given(name, axis.nodes)
    assert axis.count is not None  # the config holds either count or nodes
    return Axis.spaced(name, axis.count, *full(), axis.spacing, axis.through)


def _given(table: TableConfig, base: Path) -> Given:
    """The table of a file, found relative to `base`."""
    assert table.file is not None
    assert table.scale is not None  # the config says 1 where nobody says otherwise
    axes = {n: _axis(n, a, lambda n=n, a=a: full_range(n, a.low, a.high)) for n, a in table.axes.items()}
    contract = claim(
        table.model, table.options, table.quantity, table.lobe, table.transport, table.quantity_options
    )
    return Given(
        read_table(
            base / table.file,
            axes,
            contract,
            table.stored,
            table.order,
            channel=table.channel,
            scale=table.scale,
        )
    )


def _request(table: TableConfig, base: Path) -> Request | Given:
    try:
        if table.file is not None:
            return _given(table, base)
        bsdf = model(table.model, **table.options)
        quantity_ = quantity(table.quantity, table.lobe, table.transport, **table.quantity_options)
        axes = {
            n: _axis(n, a, lambda n=n, a=a: default_range(bsdf, quantity_, n, (a.low, a.high)))
            for n, a in table.axes.items()
        }
        assert table.tolerance is not None  # the config says one for whatever is integrated
        return Request.make(
            bsdf,
            axes,
            table.quantity,
            table.lobe,
            table.transport,
            table.tolerance,
            table.quantity_options,
        )
    except EcfitError as error:
        raise EcfitError(f"table '{table.name}': {error}") from None


def make_plan(config: StudyConfig, base: Path) -> Plan:
    """Resolve a config; plugins and tables' files are found relative to `base`.

    Raises `EcfitError` for what cannot be done.
    """
    plugins = load_plugins(config.plugins, base)
    requests = {table.name: _request(table, base) for table in config.tables}
    fits: list[PlannedFit] = []
    searches: dict[str, PlannedSearch] = {}
    for section in config.fits:
        for settings in section.settings():
            made = form(section.form, **settings)
            for name in section.tables:
                grid = requests[name].grid
                norm = "" if section.norm == "least-squares" else f"-{section.norm}"
                label = section.name or f"{name}-{made.name}-{made.degree.replace('/', '-')}{norm}"
                if not _FILE_NAME.fullmatch(label):
                    raise EcfitError(
                        f"fit {label!r}: no file can have this name; give the fit a name of plain words"
                    )
                rest = section.norm_settings()
                try:
                    check_data(grid, made)
                    check_asked(made, rest, grid.names)
                except EcfitError as error:
                    raise EcfitError(f"fit '{label}': {error}") from None
                text: list[Any] = [FITTING_VERSION, requests[name].key, made.name, made.degree]
                if section.form not in ("polynomial", "rational") or rest:
                    text += [settings, rest]
                if isinstance(made, Composition):
                    text.append(_part_keys(made, label, fits))
                if section.module is not None:
                    text.append(source_hash(factory_of(section.module)))
                key = _hash(text)
                own = _searches(name, requests[name].key, made)
                same = [f.key == key for f in fits if f.label == label]
                if not all(same):
                    raise EcfitError(f"fit '{label}': two different fits have this name: give each a name")
                if not same:
                    fits.append(PlannedFit(name, made, label, key, rest, section.name, tuple(own)))
                    searches |= own
    compare: dict[str, tuple[Approximation, ...]] = {}
    lookups: dict[str, tuple[Request, ...]] = {}
    for section in config.compare:
        found = tuple(map(published, section.published or ())) + tuple(map(shipped, section.shipped or ()))
        for name in section.tables:
            for approximation in found:
                _check_coordinates(approximation, name, requests[name])
            compare[name] = compare.get(name, ()) + found
            lookups[name] = lookups.get(name, ()) + _lookups(section, name, requests[name])
    return Plan(config, requests, tuple(fits), tuple(searches.values()), compare, lookups, plugins)


def _part_keys(made: Composition, label: str, fits: list[PlannedFit]) -> list[str]:
    """The keys of the fits that a form is composed of. Raises `EcfitError` where one is not named before."""
    known = {f.name: f.key for f in fits if f.name is not None and not isinstance(f.form, Composition)}
    for _, name in made.parts:
        if name not in known:
            raise EcfitError(f"fit '{label}': {unknown('fit named before it', name, known)}")
    return [known[name] for _, name in made.parts]


def _hash(text: list[Any]) -> str:
    return hashlib.sha256(json.dumps(text).encode()).hexdigest()[:16]


def _searches(table: str, key: str, form: Form) -> dict[str, PlannedSearch]:
    """The searches of a form by key; none where it has its terms."""
    if not isinstance(form, Selected):
        return {}
    same = [SEARCH_VERSION, key, form.whole.to_dict(), form.budgets, form.rounds, form.price]
    same += [] if form.rounding is None else [form.rounding]
    found = [PlannedSearch(table, form, seed, _hash([*same, seed])) for seed in range(form.seeds)]
    return {search.key: search for search in found}


def _check_coordinates(approximation: Approximation, name: str, table: Request | Given) -> None:
    try:
        axes = {axis.name: axis.nominal for axis in table.grid.axes}
        approximation.nodes_of(axes, table.contract.parameters)
    except EcfitError as error:
        raise EcfitError(f"table '{name}' cannot judge {approximation.name}: {error}") from None


def _lookups(section: CompareConfig, name: str, table: Request | Given) -> tuple[Request, ...]:
    """Requests of the look-up tables that a section judges on a table."""
    if not section.lookups:
        return ()
    if not isinstance(table, Request):
        raise EcfitError(f"table '{name}' is read from a file: look-ups stand for tables that are integrated")
    try:
        return tuple(lookup_request(table, item.counts, item.through) for item in section.lookups)
    except EcfitError as error:
        raise EcfitError(f"table '{name}': {error}") from None
