"""`Fit`: an approximation with an honest account of how good it is on the table it was fitted to."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import equinox as eqx
import numpy as np

from ecfit._jax import jax
from ecfit.approximation import Approximation
from ecfit.display import facts
from ecfit.errors import EcfitError
from ecfit.files import read_json, write_json
from ecfit.forms import Minimum, Terms
from ecfit.metrics import Errors, measure, prediction_range
from ecfit.tables import Table

Array = jax.Array

# Largest errors up to this are rounding: there is nothing to choose between them.
EXACT = 1e-9

STATUSES = {
    "converged": "the solver converged and the denominator is positive on the whole domain",
    "not-converged": "the solver stopped before it converged",
    "pole": "the denominator vanishes in the domain",
}


@dataclass(frozen=True, eq=False)
class Fit:
    """An approximation fitted to a table, with its errors on the table's nodes.

    Attributes:
        approximation: the evaluated form; calling the fit calls it.
        errors: MAE, RMSE, maximum with its place, over all finite entries.
        smallest: minimum of the denominator over the whole domain.
        prediction: (low, high) of the fit on the nodes and on a grid between them.
        status: a name of `STATUSES`.
        iterations: Levenberg-Marquardt steps of the chosen start, all stages.
        starts: number of starts that were tried.
        table_key: key of the table it was fitted to.
        least_max_error: lower bound of the largest error of any choice of coefficients, where it was asked
            for; see `ecfit.fitting.least`.
        least_tight: whether coefficients were found whose largest error comes near to that bound.
    """

    approximation: Approximation
    errors: Errors
    smallest: Minimum
    prediction: tuple[float, float]
    status: str
    iterations: int
    starts: int
    table_key: str = ""
    least_max_error: float | None = None
    least_tight: bool = True

    def __call__(self, **coordinates: Any) -> Array:
        """The value at physical coordinates; see `Approximation.__call__`."""
        return self.approximation(**coordinates)

    @property
    def coefficients(self) -> np.ndarray:
        """Plain-monomial coefficients: numerator, then denominator without its constant 1."""
        return self.approximation.coefficients

    @property
    def terms(self) -> Terms:
        """Exponents that give the coefficients their meaning. Raises `EcfitError` where it is no quotient."""
        return self.approximation.terms

    @property
    def module(self) -> eqx.Module:
        """The fitted Equinox module, its arrays the coefficients.

        Raises `EcfitError` where the form is no module.
        """
        return self.approximation.module

    @property
    def mae(self) -> float:
        """Mean absolute error over the finite entries of the table, in the unit of its values."""
        return self.errors.mae

    @property
    def rmse(self) -> float:
        """Root of the mean squared error over the same entries."""
        return self.errors.rmse

    @property
    def max_error(self) -> float:
        """Largest absolute error over the same entries; its place is in `errors`."""
        return self.errors.max_error

    @property
    def max_over_least(self) -> float | None:
        """The largest error in units of the least possible one; nothing where that is unknown.

        1 for a fit that is exact to rounding; below 1 only where it breaks the limits that the bound keeps.
        """
        if self.least_max_error is None:
            return None
        if self.max_error <= EXACT:
            return 1.0
        return self.max_error / self.least_max_error if self.least_max_error > 0.0 else np.inf

    def least_note(self) -> str:
        """`max_over_least` for people; empty where it is unknown, "at most" where the bound is not tight."""
        ratio = self.max_over_least
        if ratio is None:
            return ""
        return f"{ratio:.3g}" if self.least_tight else f"at most {ratio:.3g}"

    def least_line(self) -> str:
        """The largest error beside the least that the form can have, or nothing where that is unknown."""
        if self.least_max_error is None:
            return ""
        tight = "" if self.least_tight else " (a bound that is not tight)"
        return (
            f"largest error {self.least_note()} times the least possible, {self.least_max_error:.4e}{tight}"
        )

    @property
    def ok(self) -> bool:
        """Whether the fit may be used without a second look."""
        return self.status == "converged"

    def warning(self) -> str:
        """One line that says what is wrong, or nothing."""
        if self.status == "pole":
            place = ", ".join(
                f"{n} = {v:.4g}"
                for n, v in zip(self.approximation.variables, self.smallest.place, strict=True)
            )
            return (
                f"{self.approximation.name} HAS A POLE: its denominator falls to "
                f"{self.smallest.value:.3g} at {place}; do not use it, try another degree"
            )
        if self.status == "not-converged":
            return f"{self.approximation.name} DID NOT CONVERGE after {self.iterations} steps"
        return ""

    def __repr__(self) -> str:
        return (
            f"<Fit {self.approximation.name}: {self.approximation.count} coefficients, RMSE {self.rmse:.3e}, "
            f"largest error {self.max_error:.3e}, {self.status}>"
        )

    def describe(self) -> list[str]:
        """What it is, its errors, and the range of its values, a line each."""
        place = ", ".join(f"{k} = {v:.4g}" for k, v in self.errors.place.items())
        lines = [
            f"{self.approximation.name}: {self.approximation.count} coefficients, {self.status}",
            f"MAE {self.mae:.4e}, RMSE {self.rmse:.4e}, largest error {self.max_error:.4e} at {place}",
            self.least_line(),
            f"smallest denominator {self.smallest.value:.4g}, values in [{self.prediction[0]:.6g}, "
            f"{self.prediction[1]:.6g}], {self.iterations} steps, {self.starts} starts",
        ]
        return [line for line in lines if line]

    def __str__(self) -> str:
        return "\n".join([*self.describe(), *([f"WARNING: {self.warning()}"] if self.warning() else [])])

    def _repr_html_(self) -> str:
        first, errors, *rest = self.describe()
        rows = [("errors", errors), ("formula", "; ".join(rest)), *self.approximation.contract.describe()]
        return facts(first, rows, self.warning())

    def to_code(self, language: str, **options: Any) -> str:
        """Source text of a function that computes this, errors in its comment; see `ecfit.export.code`."""
        from ecfit.export import code, evidence_of

        return code(self.approximation, language, **{"evidence": evidence_of(self.to_dict()), **options})

    def to_dict(self) -> dict[str, Any]:
        """A JSON-ready dictionary that `from_dict` reads back."""
        return {
            **self.approximation.to_dict(),
            "fit": {
                "table": self.table_key,
                "status": self.status,
                "iterations": self.iterations,
                "starts": self.starts,
                "errors": self.errors.to_dict(),
                "smallest_denominator": {
                    "value": self.smallest.value,
                    "place": list(self.smallest.place),
                    "bound": self.smallest.bound,
                },
                "prediction": list(self.prediction),
                **self._least(),
            },
        }

    def _least(self) -> dict[str, Any]:
        """What the JSON says of the lower bound: nothing where it is unknown."""
        if self.least_max_error is None:
            return {}
        loose = {} if self.least_tight else {"least_tight": False}
        return {"least_max_error": self.least_max_error, **loose}

    @classmethod
    def from_dict(cls, data: Any, where: str = "fit") -> "Fit":
        """Read what `to_dict` wrote; raises `EcfitError` for anything else."""
        approximation = Approximation.from_dict(data, where)
        try:
            fitted = data["fit"]
            if fitted["status"] not in STATUSES:
                raise EcfitError(f"{where}: unknown status '{fitted['status']}'")
            smallest = fitted["smallest_denominator"]
            return cls(
                approximation,
                Errors.from_dict(fitted["errors"]),
                Minimum(
                    float(smallest["value"]), tuple(map(float, smallest["place"])), float(smallest["bound"])
                ),
                _range(fitted["prediction"]),
                fitted["status"],
                int(fitted["iterations"]),
                int(fitted["starts"]),
                str(fitted["table"]),
                float(fitted["least_max_error"]) if "least_max_error" in fitted else None,
                bool(fitted.get("least_tight", True)),
            )
        except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
            raise EcfitError(f"{where}: malformed fit ({type(error).__name__}: {error})") from None

    def save(self, path: str | Path) -> None:
        """Write JSON."""
        write_json(Path(path), self.to_dict())

    @classmethod
    def load(cls, path: str | Path) -> "Fit":
        """Read JSON written by `save`; raises `EcfitError` for anything else."""
        return cls.from_dict(read_json(Path(path)), f"'{path}'")


def _range(ends: Any) -> tuple[float, float]:
    """(low, high) from JSON, where null stands for infinity."""
    low, high = ends
    return (-np.inf if low is None else float(low), np.inf if high is None else float(high))


def judged(approximation: Approximation, table: Table, converged: bool, steps: int, starts: int) -> Fit:
    """The fit of an approximation to a table: errors, smallest denominator, range, status."""
    smallest = approximation.smallest_denominator()
    return Fit(
        approximation,
        measure(approximation, table),
        smallest,
        prediction_range(approximation, table),
        "pole" if smallest.bound <= 0.0 else "converged" if converged else "not-converged",
        steps,
        starts,
        str(table.provenance.get("key", "")),
    )
