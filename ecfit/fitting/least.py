"""The least maximal error that a form can have on a table, beside what its fit has.

A large quotient of the two says that other coefficients would do better at the maximum; one near 1 that only
another form would.
"""

from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from ecfit.approximation.structured import StructuredFormula
from ecfit.errors import EcfitError
from ecfit.fitting.minimax import minimax
from ecfit.fitting.result import EXACT, Fit
from ecfit.fitting.selection import descent_for
from ecfit.fitting.structured import domain_of, structured_from, table_range
from ecfit.forms import ModuleForm, Selected, Structured
from ecfit.tables import Table

# A bound is tight where some coefficients come this near to it, or where both are rounding.
_TIGHT = 1e-3


class Least(NamedTuple):
    """A lower bound of the largest error, and whether coefficients were found that come near to it."""

    error: float
    tight: bool


def check_bounded(form: Any, lower_bound: Any) -> None:
    """Raise `EcfitError` where no lower bound can be computed for a form, before it is fitted."""
    if not isinstance(lower_bound, bool):
        raise EcfitError(f"lower_bound must be true or false, got {lower_bound!r}")
    if not lower_bound:
        return
    if isinstance(form, ModuleForm):
        raise EcfitError("lower_bound is for forms with terms, not for modules: leave it out")
    structure = getattr(form, "structure", None) if isinstance(form, Structured) else None
    structure = form.whole if isinstance(form, Selected) else structure
    if structure is not None and structure.head.ratios > 1:
        raise EcfitError(
            f"lower_bound is for heads of one ratio; '{structure.head.name}' has {structure.head.ratios}: "
            "leave it out"
        )
    if find_spec("scipy") is None:
        raise EcfitError("lower_bound needs SciPy: pip install 'ecfit[minimax]'")


def least_max_error(fit: Fit, table: Table, margin: float = 0.0) -> Least:
    """A proved lower bound of the largest error of a fit's form on all nodes of its table.

    It holds for all coefficients that keep the form's limits, `margin` included, and Q > 0 (a thousandth of
    its mean) at guards over the closed domain: a fit may pass below it only by breaking them. Raises
    `EcfitError` as `check_bounded`, and for heads that are not linear in their ratio.
    """
    approximation, formula = fit.approximation, fit.approximation.formula
    if isinstance(formula, StructuredFormula):
        structure, start = formula.structure, formula.values
        domain = domain_of(structure, table)
    else:
        form = structured_from(approximation)
        structure, start = form.structure, np.array(form.start)
        # A rational has no poles on the table's own range, and may have some beyond.
        domain = {name: table_range(table, name) for name in structure.variables}
    descent = descent_for(structure, table, domain)
    if descent.affine is None:
        raise EcfitError(
            f"lower_bound is for heads that are linear in their ratio, not '{structure.head.name}': "
            "leave it out"
        )
    support = [list(range(len(n))) for n in structure.numerators]
    support.append(list(range(1, len(structure.denominator))))
    found = minimax(descent, support, 0, start, least=margin, proved=True)
    return Least(found.bound, found.error <= found.bound * (1.0 + _TIGHT) + EXACT)
