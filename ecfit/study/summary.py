"""What a study's CSV files say: a row a fit or approximation, and a row a candidate of a search."""

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ecfit.approximation import Approximation
from ecfit.approximation.standing import standing_status
from ecfit.fitting import Fit
from ecfit.fitting.selection import Choice, front
from ecfit.metrics import Errors

# Table name -> what is judged beside its fits, with its errors there.
Others = Mapping[str, Sequence[tuple[Approximation, Errors]]]
# Table name -> (form, the best that its searches found of every size).
Searches = Mapping[str, Sequence[tuple[str, Sequence[Choice]]]]

SUMMARY_COLUMNS = (
    "table",
    "form",
    "degree",
    "coefficients",
    "mae",
    "rmse",
    "max_error",
    "min_denominator",
    "status",
    "max_error_at",
    "furnace_mean",
    "furnace_max",
    "prediction_low",
    "prediction_high",
    "iterations",
    "max_over_least",
)

# `rms` is in the search's own weights, `cost` in multiply-adds; `front`: none is better at less cost.
SEARCH_COLUMNS = (
    "table", "form", "coefficients", "rms", "multiply_adds", "divisions", "roots", "cost", "front",
)  # fmt: skip


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A CSV file: a header and rows."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def _number(value: float) -> str:
    return f"{value:.6e}"


def _ratio(value: float | None) -> str:
    """Empty where nothing is known: an infinite ratio is to a bound of 0."""
    return "" if value is None or value == float("inf") else _number(value)


def summary_row(table: str, fit: Fit) -> tuple[Any, ...]:
    """The row of a fit in `summary.csv`."""
    return (
        table,
        fit.approximation.form,
        fit.approximation.degree,
        fit.approximation.count,
        *_error_cells(fit.errors),
        _number(fit.smallest.value),
        fit.status,
        _place(fit.errors),
        _number(fit.errors.furnace_mean),
        _number(fit.errors.furnace_max),
        _number(fit.prediction[0]),
        _number(fit.prediction[1]),
        fit.iterations,
        _ratio(fit.max_over_least),
    )


def summary_rows(fits: Mapping[str, Sequence[Fit]], others: Others) -> Iterator[tuple[Any, ...]]:
    """The rows of `summary.csv`: the fits of each table, then what is judged beside them."""
    for name, of_table in fits.items():
        for fit in of_table:
            yield summary_row(name, fit)
    for name, rows in others.items():
        for approximation, errors in rows:
            smallest = approximation.smallest_denominator()
            yield (
                name,
                approximation.name,
                approximation.degree,
                approximation.count,
                *_error_cells(errors),
                _number(smallest.value),
                standing_status(approximation, smallest),
                _place(errors),
                _number(errors.furnace_mean),
                _number(errors.furnace_max),
                "",
                "",
                "",
                "",
            )


def search_rows(searches: Searches) -> Iterator[tuple[Any, ...]]:
    """The rows of `searches.csv`: of each form the best of every size."""
    for table, of_table in searches.items():
        for form, found in of_table:
            best = front(found)
            for choice in found:
                cost = choice.cost
                yield (
                    table,
                    form,
                    choice.count,
                    _number(choice.rms),
                    cost.multiply_adds,
                    cost.divisions,
                    cost.roots,
                    f"{cost.total:g}",
                    "yes" if choice in best else "",
                )


def _error_cells(errors: Errors) -> tuple[str, str, str]:
    return _number(errors.mae), _number(errors.rmse), _number(errors.max_error)


def _place(errors: Errors) -> str:
    return " ".join(f"{k}={v:.6g}" for k, v in errors.place.items())
