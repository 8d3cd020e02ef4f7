"""From a config to what has to be computed: every name resolved, every domain checked, nothing computed."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from ecfit.approximation import Approximation, published
from ecfit.bsdf import BSDF, model
from ecfit.config import AxisConfig, StudyConfig, TableConfig
from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.fitting.fit import check_data
from ecfit.forms import Form, form
from ecfit.quantities import Quantity, quantity
from ecfit.study.plugins import load_plugins
from ecfit.tables import Request
from ecfit.tables.tabulate import default_range

# Raise this when a change moves the coefficients of fits: it is part of every fit's key.
FITTING_VERSION = 3


@dataclass(frozen=True)
class PlannedFit:
    """One form on one table. `label` names its file: table-form-degree."""

    table: str
    form: Form
    label: str
    key: str


@dataclass(frozen=True)
class Plan:
    """A checked study: requests by table name, fits in order, published fits by table."""

    config: StudyConfig
    requests: dict[str, Request]
    fits: tuple[PlannedFit, ...]
    compare: dict[str, tuple[Approximation, ...]]


def _axis(name: str, axis: AxisConfig, bsdf: BSDF, quantity_: Quantity) -> Axis:
    if axis.nodes is not None:
        return Axis.given(name, axis.nodes)
    low, high = default_range(bsdf, quantity_, name, (axis.low, axis.high))
    assert axis.count is not None  # the config holds either count or nodes
    return Axis.spaced(name, axis.count, low, high, axis.spacing, axis.through)


def _request(table: TableConfig) -> Request:
    try:
        bsdf = model(table.model, **table.options)
        quantity_ = quantity(table.quantity, table.lobe, table.transport, **table.quantity_options)
        axes = {name: _axis(name, axis, bsdf, quantity_) for name, axis in table.axes.items()}
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
    """Resolve a config; plugins are found relative to `base`. Raises `EcfitError` for what cannot be done."""
    load_plugins(config.plugins, base)
    requests = {table.name: _request(table) for table in config.tables}
    fits: list[PlannedFit] = []
    for section in config.fits:
        for settings in section.settings():
            made = form(section.form, **settings)
            for name in section.tables:
                grid = requests[name].grid
                label = f"{name}-{made.name}-{made.degree.replace('/', '-')}"
                try:
                    check_data(grid, made)
                except EcfitError as error:
                    raise EcfitError(f"fit '{label}': {error}") from None
                text = [FITTING_VERSION, requests[name].key, made.name, made.degree]
                key = hashlib.sha256(json.dumps(text).encode()).hexdigest()[:16]
                if label not in [f.label for f in fits]:
                    fits.append(PlannedFit(name, made, label, key))
    compare: dict[str, tuple[Approximation, ...]] = {}
    for section in config.compare:
        found = tuple(published(name) for name in section.published)
        for name in section.tables:
            for approximation in found:
                if set(approximation.variables) != set(requests[name].grid.names):
                    raise EcfitError(
                        f"published fit '{approximation.name}' is a function of "
                        f"{', '.join(approximation.variables)}, table '{name}' of "
                        f"{', '.join(requests[name].grid.names)}"
                    )
            compare[name] = compare.get(name, ()) + found
    return Plan(config, requests, tuple(fits), compare)
