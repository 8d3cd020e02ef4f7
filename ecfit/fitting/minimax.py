"""The least possible maximal error of a quotient: differential correction, a sequence of linear programs.

Minimising the maximum of |P / Q - f| over Q > 0 is quasi-convex, so what is found is the global optimum on
the given points: no choice of coefficients does better there, which makes it the lower bound of a form
(Barrodale, Powell & Roberts 1972).
"""

from typing import NamedTuple

import numpy as np

from ecfit.errors import EcfitError
from ecfit.fitting.descent import Descent, slopes_at

# The program ends when an iteration lowers the maximum by less than this part.
_SETTLED = 1e-6
_PROGRAMS = 40
# Q, of mean 1 over the rows, stays above this.
_LEAST_Q = 1e-3
# Rows of the first program, and the worst offenders added a round: the rest hardly ever bind.
_ACTIVE = 1500
_ADDED = 300
# Bounds of the scaled coefficients in the programs.
_LARGEST = 1e4
# A proof is tried of the level less these parts of it, in turn: a program's rounding may hide the first.
_PARTS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
# Rounding of a start that lies on the limits, in parts of the largest entry of a row.
_SLACK = 1e-9


class Minimax(NamedTuple):
    """Coefficients, their maximal error, a lower bound of it over all coefficients, and programs solved.

    The bound is the optimum on the rows of the last differential correction that came to its end, to a
    millionth; if asked for, one below it that duality proves for all scaled coefficients up to 1e4.
    """

    coefficients: np.ndarray
    error: float
    bound: float
    converged: bool
    programs: int


def minimax(
    descent: Descent,
    support: list[list[int]],
    leading: int,
    start: np.ndarray,
    *,
    relative: bool = False,
    least: float = 0.0,
    rows: np.ndarray | None = None,
    proved: bool = False,
) -> Minimax:
    """The minimax fit on the rows of a descent, within the head's limits at its guards.

    Args:
        start: coefficients to begin from (with Q > 0).
        least: what the head holds stays above this at the guards.
        relative: minimise the largest |E / e - 1| instead of |e - E|.
        rows: mask of the rows that count.
        proved: whether the bound has to be proved, with a few more programs.

    Raises `EcfitError` where SciPy is missing (extra `minimax`) or the head has more than one ratio.
    """
    try:
        from scipy.optimize import linprog
    except ImportError:
        raise EcfitError("minimax needs SciPy: pip install 'ecfit[minimax]'") from None
    if descent.affine is None:
        raise EcfitError(f"minimax is for heads of one ratio, not '{descent.head.name}'")
    base, slope = descent.affine
    keep = np.ones(len(base), dtype=bool) if rows is None else rows
    base, slope, y = base[keep], slope[keep], descent.target.values[keep]
    columns = [x[:, s] for x, s in zip(descent.columns, support, strict=True)]
    p, q = (x[keep] for x in columns)
    q0 = descent.columns[-1][keep, leading]
    guards = descent.guard_columns[-1]
    gq0, gq = guards[:, leading], guards[:, support[1]]
    unit = float(q0.mean())
    norms = np.concatenate([np.abs(p * slope[:, None]).mean(axis=0), np.abs(q).mean(axis=0)]) / unit
    norms = np.where(norms > 0.0, norms, 1.0)
    split = p.shape[1]
    # Residual times Q, e Q, and Q as linear functions (constant, coefficients) of the scaled coefficients.
    n = np.concatenate([p * slope[:, None], (base - y)[:, None] * q], axis=1) / norms, (base - y) * q0
    e = np.concatenate([p * slope[:, None], base[:, None] * q], axis=1) / norms, base * q0
    d = np.concatenate([np.zeros_like(p), q], axis=1) / norms, q0
    measured = e if relative else d
    limits = _limits(descent, support, gq0, gq, split, norms, unit, least)

    def error_of(z: np.ndarray) -> np.ndarray:
        return np.abs(n[0] @ z + n[1]) / (measured[0] @ z + measured[1])

    def program(active: np.ndarray, level: float, weight: np.ndarray) -> tuple[np.ndarray | None, float]:
        """The least lambda with +-(residual Q) - level measured <= lambda weight, and a bound of it.

        Returns the coefficients, nothing where the program fails, and what duality proves of lambda.
        """
        nonlocal programs
        rows_n, const_n = n[0][active], n[1][active]
        rows_m, const_m = measured[0][active], measured[1][active]
        upper = np.concatenate(
            [
                np.c_[rows_n - level * rows_m, -weight],
                np.c_[-rows_n - level * rows_m, -weight],
                np.c_[limits[0], np.zeros(len(limits[0]))],
            ]
        )
        right = np.concatenate([level * const_m - const_n, level * const_m + const_n, limits[1]])
        size = np.abs(upper).max(axis=1)
        upper, right = upper / size[:, None], right / size
        solved = linprog(
            np.r_[np.zeros(upper.shape[1] - 1), 1.0], A_ub=upper, b_ub=right,
            bounds=[(-_LARGEST, _LARGEST)] * (upper.shape[1] - 1) + [(None, None)], method="highs",
        )  # fmt: skip
        programs += 1
        if solved.x is None:
            return None, -np.inf
        # Any multipliers >= 0 with weight 1 on lambda bound it from below; those of the program do it best.
        multipliers = np.maximum(-solved.ineqlin.marginals, 0.0)
        total = -float(multipliers @ upper[:, -1])
        if not total > 0.0:
            return solved.x[:-1], -np.inf
        multipliers /= total
        lost = _LARGEST * float(np.abs(multipliers @ upper[:, :-1]).sum())
        return solved.x[:-1], -float(multipliers @ right) - lost

    z = start * norms
    # A start beyond the limits bounds nothing, and may have a smaller error than is possible within them.
    q_least = float((d[0] @ z + d[1]).min())
    within = q_least > 0.0 and bool(
        np.all(limits[0] @ z <= limits[1] + _SLACK * np.abs(limits[0]).max(axis=1))
    )
    best, best_error = z, float(error_of(z).max()) if within else np.inf
    order = np.argsort(-error_of(z))
    active = np.unique(np.concatenate([order[:_ADDED], np.linspace(0, len(y) - 1, _ACTIVE).astype(int)]))
    bound, programs, converged = 0.0, 0, False
    last: tuple[np.ndarray, float, np.ndarray] | None = None
    # The first coefficients within the limits may have a Q of any shape, a bad weight: first even weights.
    even = not within
    while programs < _PROGRAMS:
        # Differential correction on the active rows.
        t, failed, settled = z, False, False
        level = float(np.abs(error_of(z))[active].max())
        for _ in range(_PROGRAMS):
            weight = np.maximum((measured[0] @ t + measured[1])[active], 1e-6 * unit)
            if even:
                weight = np.full(len(active), unit)
            found = program(active, level, weight)[0]
            if found is None:
                failed = True
                break
            t = found
            inner = float(error_of(t)[active].max())
            if not within:
                within, even, level = True, True, inner
                continue
            if even and not inner < level * (1.0 - _SETTLED):
                even = False
                continue
            if not inner < level * (1.0 - _SETTLED):
                level, settled = min(level, inner), True
                break
            level = inner
        if failed:
            break
        # The active rows are some of all: their optimum bounds that of all from below. A level that still
        # fell when the programs ran out is no optimum, and no bound.
        if settled:
            bound, last = level, (active, level, t)
        errors = error_of(t)
        if errors.max() < best_error:
            best, best_error = t, float(errors.max())
        if not settled:
            break
        worst = np.argsort(-errors)[:_ADDED]
        more = np.setdiff1d(worst[errors[worst] > level * (1.0 + 1e-6)], active)
        if not len(more):
            converged = True
            break
        active, z = np.union1d(active, more), best
    if np.isinf(best_error):
        best_error = float(error_of(best).max())
    if proved and last is not None:
        active, level, t = last
        weight = np.maximum((measured[0] @ t + measured[1])[active], 1e-6 * unit)
        # Lambda > 0 at a level: no coefficients reach it.
        tried = (level * (1.0 - part) for part in _PARTS)
        bound = next((low for low in tried if program(active, low, weight)[1] > 0.0), 0.0)
    return Minimax(best / norms, best_error, bound, converged, programs)


def _limits(
    descent: Descent,
    support: list[list[int]],
    gq0: np.ndarray,
    gq: np.ndarray,
    split: int,
    norms: np.ndarray,
    unit: float,
    least: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Rows A, b of A z <= b: Q above its least, what is held (times Q) above `least`, at the guards."""
    zeros = np.zeros((len(gq), split))
    rows, right = [np.concatenate([zeros, -gq], axis=1) / norms], [gq0 - _LEAST_Q * unit]
    guards = descent.guards
    for i, factors in enumerate(guards.factors):
        # What is linear in X is base + slope X: times Q it is linear in the coefficients.
        found = [
            np.asarray(slopes_at(x * np.ones_like(factors), guards.data, head=descent.head, held=i)[0])
            for x in (0.0, 1.0)
        ]
        base, slope = found[0] - least, (found[1] - found[0]) * factors[0]
        gp = descent.guard_columns[0][:, support[0]]
        rows.append(-np.concatenate([gp * slope[:, None], gq * base[:, None]], axis=1) / norms)
        right.append(gq0 * base)
    stacked = np.concatenate(rows)
    keep = np.abs(stacked).max(axis=1) > 0.0
    return stacked[keep], np.concatenate(right)[keep]
