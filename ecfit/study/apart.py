"""How far two runs of one study are apart: what another processor, or another number of threads, changes."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ecfit.approximation import Approximation
from ecfit.config import read_config
from ecfit.errors import EcfitError
from ecfit.files import read_json
from ecfit.fitting import Fit
from ecfit.fitting.result import EXACT
from ecfit.study.fits import fit_path
from ecfit.study.plan import PlannedFit, make_plan
from ecfit.study.runner import table_path
from ecfit.tables import Table

# What is promised of two runs of one config with the same versions, on any processor and with any number of
# threads or workers (docs/trust.md has what was measured). Of an entry of a table, in units of its tolerance:
# measured were 6e-8; one whose estimate is just at the tolerance may take a finer rule in one run only.
SAME_ENTRY = 1e-3
# Of a fitted function anywhere in its domain, in units of the fit's largest error: measured were 1e-6.
SAME_FUNCTION = 1e-4

# Nodes an axis at which functions are compared, by the number of variables: ends included.
_NODES = {1: 2049, 2: 129, 3: 33}
_FEW = 9


@dataclass(frozen=True)
class Apart:
    """What differs between two runs in one fit.

    Attributes:
        label: of the fit: the name of its file.
        coefficients: largest |a - b| / |a| of a coefficient; infinite where the terms differ.
        function: largest |f_a - f_b| on a grid over the closed domain; infinite where only one is finite.
        max_error: the fit's largest error, of the first run.
    """

    label: str
    coefficients: float
    function: float
    max_error: float

    @property
    def share(self) -> float:
        """`function` in units of the fit's largest error; an error of rounding counts as `EXACT`."""
        return self.function / max(self.max_error, EXACT)

    @property
    def same(self) -> bool:
        """Whether it is the same fit for every use."""
        return self.share <= SAME_FUNCTION


def entries_apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """|a - b|: 0 where neither is finite (NaN, or 0 / 0 at an edge, in both), infinite where only one is."""
    with np.errstate(all="ignore"):
        off = np.nan_to_num(np.abs(a - b), nan=np.inf, posinf=np.inf)
    return np.where(np.isfinite(a) | np.isfinite(b), off, 0.0)


def _in_units(off: np.ndarray, unit: np.ndarray | float) -> float:
    """Largest off / unit; 0 / 0 is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.max(np.where((off == 0.0) | np.isinf(off), off, off / unit), initial=0.0))


def functions_apart(a: Approximation, b: Approximation) -> float:
    """Largest |a - b| on a grid over the closed domain, limits at its edges included.

    Nodes at which both are not finite (0 / 0 at an edge) count as equal. Raises `EcfitError` for other
    variables or domains.
    """
    if (a.variables, a.domain) != (b.variables, b.domain):
        raise EcfitError(f"'{a.name}' and '{b.name}' have other variables or domains: nothing to compare")
    nodes = [np.linspace(low, high, _NODES.get(len(a.domain), _FEW)) for low, high in a.domain]
    with np.errstate(all="ignore"):
        one, other = a.on_grid(nodes), b.on_grid(nodes)
    return float(np.max(entries_apart(one, other), initial=0.0))


def coefficients_apart(a: np.ndarray, b: np.ndarray) -> float:
    """Largest |a - b| / |a|; 0 / 0 is 0. Infinite where the two differ in number."""
    if a.shape != b.shape:
        return float("inf")
    return _in_units(entries_apart(a, b), np.abs(a))


def _terms(data: Any) -> Any:
    """What a formula's data say beside its coefficients, those of its parts too."""
    if isinstance(data, dict):
        return {k: _terms(v) for k, v in data.items() if k != "coefficients"}
    return [_terms(v) for v in data] if isinstance(data, list | tuple) else data


def fits_apart(config: str | Path, old: str | Path, new: str | Path) -> list[Apart]:
    """The fits of two runs of one study file, in its order.

    Args:
        config: the study file of both.
        old, new: the folders of all results (`--results`) of the two runs.

    Raises `EcfitError` where a fit is missing, or is not the one that the study file asks for.
    """
    plan = make_plan(read_config(Path(config)), Path(config).parent)
    out = []
    for planned in plan.fits:
        a, b = (_stored(planned, fit_path(planned, Path(root) / plan.config.name)) for root in (old, new))
        same = _terms(a.approximation.formula.to_dict()) == _terms(b.approximation.formula.to_dict())
        out.append(
            Apart(
                planned.label,
                coefficients_apart(a.coefficients, b.coefficients) if same else float("inf"),
                functions_apart(a.approximation, b.approximation),
                a.max_error,
            )
        )
    return out


def _stored(planned: PlannedFit, path: Path) -> Fit:
    data = read_json(path)
    fit = Fit.from_dict(data, f"'{path}'")
    if data.get("key") != planned.key:
        raise EcfitError(f"'{path}' is a fit of another study file or version of ecfit: run the study again")
    return fit


def tables_apart(config: str | Path, old: str | Path, new: str | Path) -> dict[str, float]:
    """Table -> largest difference of an entry between two runs, in units of its tolerance.

    Arguments as for `fits_apart`. Tables that were read from files differ by nothing, or by infinity. Entries
    that are NaN in both runs are equal; one that is NaN in one of them is infinitely far.
    """
    plan = make_plan(read_config(Path(config)), Path(config).parent)
    out = {}
    for name, request in plan.requests.items():
        a, b = (Table.load(table_path(request, Path(root))) for root in (old, new))
        out[name] = _in_units(entries_apart(a.values, b.values), a.tolerance if a.tolerance > 0.0 else 0.0)
    return out
