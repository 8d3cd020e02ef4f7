"""ecfit: from a BSDF to albedo tables with error estimates, rational fits and reports.

Public names are imported on first use, so that `import ecfit` (and `ecfit --help`) does not load JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ecfit.approximation import Approximation as Approximation
    from ecfit.approximation import lookup_table as lookup_table
    from ecfit.approximation import published as published
    from ecfit.approximation import shipped as shipped
    from ecfit.auditing import Audit as Audit
    from ecfit.auditing import audit as audit
    from ecfit.baking import bake as bake
    from ecfit.bsdf import BSDF as BSDF
    from ecfit.bsdf import model as model
    from ecfit.bsdf import models as models
    from ecfit.bsdf import option as option
    from ecfit.bsdf import parameter as parameter
    from ecfit.bsdf import register as register
    from ecfit.check import check_bsdf as check_bsdf
    from ecfit.compensation import Furnace as Furnace
    from ecfit.compensation import compensate as compensate
    from ecfit.compensation import furnace as furnace
    from ecfit.contract import Contract as Contract
    from ecfit.coordinates import Axis as Axis
    from ecfit.coordinates import Grid as Grid
    from ecfit.errors import EcfitError as EcfitError
    from ecfit.fitting import Fit as Fit
    from ecfit.fitting import fit as fit
    from ecfit.forms import Polynomial as Polynomial
    from ecfit.forms import Rational as Rational
    from ecfit.forms import Selected as Selected
    from ecfit.forms import Structured as Structured
    from ecfit.forms import register_form as register_form
    from ecfit.quantities import directional_albedo as directional_albedo
    from ecfit.study import Study as Study
    from ecfit.study import run as run
    from ecfit.study.verify import verify as verify
    from ecfit.tables import Table as Table
    from ecfit.tables import read_layout as read_layout
    from ecfit.tables import read_table as read_table
    from ecfit.tables import tabulate as tabulate
    from ecfit.tables import write_table as write_table

_HOME = {
    "Approximation": "ecfit.approximation",
    "lookup_table": "ecfit.approximation",
    "published": "ecfit.approximation",
    "shipped": "ecfit.approximation",
    "Audit": "ecfit.auditing",
    "audit": "ecfit.auditing",
    "bake": "ecfit.baking",
    "BSDF": "ecfit.bsdf",
    "model": "ecfit.bsdf",
    "models": "ecfit.bsdf",
    "option": "ecfit.bsdf",
    "parameter": "ecfit.bsdf",
    "register": "ecfit.bsdf",
    "check_bsdf": "ecfit.check",
    "Furnace": "ecfit.compensation",
    "compensate": "ecfit.compensation",
    "furnace": "ecfit.compensation",
    "Contract": "ecfit.contract",
    "Axis": "ecfit.coordinates",
    "Grid": "ecfit.coordinates",
    "EcfitError": "ecfit.errors",
    "Fit": "ecfit.fitting",
    "fit": "ecfit.fitting",
    "Polynomial": "ecfit.forms",
    "Rational": "ecfit.forms",
    "Selected": "ecfit.forms",
    "Structured": "ecfit.forms",
    "register_form": "ecfit.forms",
    "directional_albedo": "ecfit.quantities",
    "Study": "ecfit.study",
    "run": "ecfit.study",
    "verify": "ecfit.study.verify",
    "Table": "ecfit.tables",
    "read_layout": "ecfit.tables",
    "read_table": "ecfit.tables",
    "tabulate": "ecfit.tables",
    "write_table": "ecfit.tables",
}

__all__ = [*_HOME, "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name == "__version__":  # reading the metadata takes 40 ms: only on request
        from importlib.metadata import version

        return version("ecfit")
    if name not in _HOME:
        raise AttributeError(f"module 'ecfit' has no attribute '{name}'")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
