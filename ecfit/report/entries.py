"""`Entry`: a row of a report, the same for a study's fits and for what is judged beside them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ecfit.approximation import Approximation
from ecfit.approximation.standing import standing, standing_status
from ecfit.errors import EcfitError
from ecfit.expressions.cost import cost
from ecfit.fitting import Fit
from ecfit.forms import Minimum
from ecfit.metrics import Errors
from ecfit.tables import Table


@dataclass(frozen=True, eq=False)
class Entry:
    """An approximation judged on a table.

    Attributes:
        kind: "fit", or what `standing` says.
        approximation: what is judged.
        errors: on the nodes of the table.
        smallest: minimum of the denominator over the whole domain of the approximation.
        status: in words: of a fit its own; else the kind, and a pole where there is one.
        usable: whether it may be used without a second look.
        otherwise: the conventions in which it differs from the table.
        fit: our fit, where it is one.
    """

    kind: str
    approximation: Approximation
    errors: Errors
    smallest: Minimum
    status: str
    usable: bool
    otherwise: tuple[str, ...] = ()
    fit: Fit | None = None

    @property
    def name(self) -> str:
        return self.approximation.name

    @property
    def count(self) -> int:
        """How many numbers one has to store."""
        return self.approximation.count

    @property
    def operations(self) -> float | None:
        """Operations of an evaluation, in multiply-adds; nothing for tables, which fetch."""
        try:
            return cost(self.approximation.expression()).total
        except EcfitError:
            return None

    @property
    def furnace(self) -> tuple[float, float] | None:
        """(mean, largest) deviation of a white furnace; nothing where E reaches 0: no normaliser."""
        found = (self.errors.furnace_mean, self.errors.furnace_max)
        return found if np.isfinite(found).all() else None


def entries(
    table: Table, fits: Sequence[Fit], published: Sequence[tuple[Approximation, Errors]] = ()
) -> list[Entry]:
    """Rows of a table: our fits in their order, then what is judged beside them."""
    out = [Entry("fit", f.approximation, f.errors, f.smallest, f.status, f.ok, (), f) for f in fits]
    for approximation, errors in published:
        smallest = approximation.smallest_denominator()
        otherwise = tuple(approximation.contract.differences(table.contract))
        kind, status = standing(approximation), standing_status(approximation, smallest)
        out.append(Entry(kind, approximation, errors, smallest, status, smallest.bound > 0.0, otherwise))
    return out


def best(of: Sequence[Entry]) -> Entry | None:
    """The usable entry of the smallest RMSE, the smaller one of equals; None where none is usable."""
    usable = [e for e in of if e.usable]
    return min(usable, key=lambda e: (e.errors.rmse, e.count), default=None)
