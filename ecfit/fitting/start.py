"""Linearised starts for rational fits (Sanathanan & Koerner 1963).

Repeat: minimise the sum of |(P - f Q) / Q_prev|^2 with |Q / Q_prev| = 1. The numerator is eliminated by QR
and the denominator is the smallest singular vector of what is left.
"""

import numpy as np

from ecfit.fitting.problem import Problem, from_unit_monomials
from ecfit.forms.terms import change_basis

_ITERATIONS = 25
# Where the last denominator nearly vanishes its rows would dominate the next solve: floor its weight.
_FLOOR = 1e-2
# A lifted denominator is at least this part of its mean: room for the first steps.
_LIFT = 0.05


def _rms(problem: Problem, p: np.ndarray, q: np.ndarray, guarded: bool) -> float:
    """Weighted RMS residual; if `guarded`, infinite where Q changes sign on the rows or guards."""
    columns_p, columns_q = problem.columns
    denominator = columns_q @ q
    if guarded and (denominator.min() <= 0.0 or (problem.guards @ q).min() <= 0.0):
        return np.inf
    residual = columns_p @ p / denominator - problem.values
    return float(np.sqrt(np.average(residual**2, weights=problem.weights)))


def numerator_for(problem: Problem, q: np.ndarray) -> np.ndarray:
    """The best numerator for a given denominator: a linear least-squares problem."""
    columns_p, columns_q = problem.columns
    root = np.sqrt(problem.weights)
    return np.linalg.lstsq(columns_p * (root / (columns_q @ q))[:, None], root * problem.values, rcond=None)[
        0
    ]


def sanathanan_koerner(problem: Problem, guarded: bool = True) -> list[tuple[np.ndarray, np.ndarray]]:
    """The best iterate (p, q) with Q > 0, as a list of one; empty where none has Q > 0.

    If `guarded` is false, Q may have any sign.
    """
    columns_p, columns_q = problem.columns
    root = np.sqrt(problem.weights)
    weight = root.copy()
    found: list[tuple[float, np.ndarray, np.ndarray]] = []
    for _ in range(_ITERATIONS):
        a = columns_p * weight[:, None]
        m = columns_q * weight[:, None]
        b = m * problem.values[:, None]
        basis, triangle = np.linalg.qr(a)
        projected = basis.T @ b
        rest = b - basis @ projected
        metric = np.linalg.qr(m, mode="r")
        try:
            inverse = np.linalg.inv(metric)
            q = inverse @ np.linalg.svd(np.linalg.qr(rest, mode="r") @ inverse)[2][-1]
            p = np.linalg.solve(triangle, projected @ q)
        except np.linalg.LinAlgError:
            break
        scale = q[0] if abs(q[0]) > 1e-12 * np.abs(q).max() else np.abs(q).max()
        p, q = p / scale, q / scale
        found.append((_rms(problem, p, q, guarded), p, q))
        denominator = np.abs(columns_q @ q)
        new = root / np.maximum(denominator, _FLOOR * denominator.max())
        settled = np.linalg.norm(new - weight) <= 1e-4 * np.linalg.norm(weight)
        weight = new
        if settled:
            break
    good = sorted((entry for entry in found if np.isfinite(entry[0])), key=lambda entry: entry[0])
    return [(p, q) for _, p, q in good[:1]]


def embedded(
    problem: Problem, coarse: Problem, start: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """A start (p, q) for `problem` from the solution of a problem whose terms are among its own."""

    def spread(values: np.ndarray, few: np.ndarray, many: np.ndarray) -> np.ndarray:
        place = {tuple(row): i for i, row in enumerate(many.tolist())}
        out = np.zeros(len(many))
        out[[place[tuple(row)] for row in few.tolist()]] = values
        return out

    p, q = start
    denominator = spread(q[1:], coarse.terms.denominator, problem.terms.denominator)
    return (
        spread(p, coarse.terms.numerator, problem.terms.numerator),
        np.concatenate([q[:1], denominator]),
    )


def polynomial_start(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """The start with Q = 1."""
    q = np.zeros(1 + len(problem.terms.denominator))
    q[0] = 1.0
    return numerator_for(problem, q), q


def lifted_start(problem: Problem) -> list[tuple[np.ndarray, np.ndarray]]:
    """The unguarded linearised start with a constant added to its denominator until that is positive.

    Where the optimum has a pole, pole-free minima are near it. Empty where the start itself has none.
    """
    for _, q in sanathanan_koerner(problem, guarded=False):
        values = np.concatenate([problem.columns[1] @ q, problem.guards @ q])
        if values.mean() < 0.0:
            q, values = -q, -values
        if values.min() > 0.0:
            return []
        q = q.copy()
        q[0] += _LIFT * values.mean() - values.min()
        q = q / q[0]
        return [(numerator_for(problem, q), q)]
    return []


def ones_start(problem: Problem) -> tuple[np.ndarray, np.ndarray]:
    """The start with all coefficients of plain monomials of [0, 1] equal to 1 (Sforza & Pellacini 2022)."""
    tables = [from_unit_monomials(problem.terms.highest)] * problem.terms.variables
    constant = np.zeros((1, problem.terms.variables), dtype=np.int64)
    exponents = problem.terms.numerator, np.concatenate([constant, problem.terms.denominator])
    p, q = (change_basis(np.ones(len(e)), e, tables) for e in exponents)
    return p / q[0], q / q[0]
