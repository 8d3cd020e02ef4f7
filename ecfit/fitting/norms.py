"""What "best" means: the norms of a structured fit, by reweighted descents or linear programs.

With e the fit and E the truth, a residual is e - E, or, for the norms of the white furnace, E / e - 1: what a
renderer shows when the fit normalises a BSDF.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ecfit.errors import EcfitError
from ecfit.fitting.descent import Descent, Solved
from ecfit.fitting.minimax import minimax

Support = list[list[int]]


@dataclass(frozen=True)
class Norm:
    """A norm of the residuals.

    Attributes:
        name: how configs call it.
        meaning: for people.
        furnace: residuals E / e - 1 instead of e - E.
        power: p of the p-norm; infinite for the maximum.
        ignored: part of the weight whose residuals, the largest, count no more than the rest's largest.
    """

    name: str
    meaning: str
    furnace: bool = False
    power: float = 2.0
    ignored: float = 0.0


NORMS: dict[str, Norm] = {
    n.name: n
    for n in (
        Norm("least-squares", "root mean square of e - E"),
        Norm("l1", "mean of |e - E|", power=1.0),
        Norm("l3", "third-power mean of |e - E|: lowers the maximum for little in the mean", power=3.0),
        Norm("l4", "fourth-power mean of e - E: between least squares and the maximum", power=4.0),
        Norm("l8", "eighth-power mean of e - E: nearer to the maximum", power=8.0),
        Norm("minimax", "maximum of |e - E|", power=np.inf),
        Norm("furnace-mean", "mean of |E / e - 1|", True, 1.0),
        Norm("furnace-rms", "root mean square of E / e - 1", True),
        Norm("furnace-l4", "fourth-power mean of E / e - 1", True, 4.0),
        Norm("furnace-p99", "99th percentile of |E / e - 1|", True, 8.0, 0.01),
        Norm("furnace-max", "maximum of |E / e - 1|", True, np.inf),
    )
}

# Reweighted descents: for p < 2 they converge to the norm's optimum; for p > 2 the exponent rises step by
# step, each from the solution before, damped so that the weights settle.
_ROUNDS = 20
_RISE = 1.4
_SETTLED = 1e-4
# Residuals below this part of the RMS count as this much for p < 2: at 0 the weight would be infinite.
_FLOOR = 1e-2


def solve_in_norm(
    descent: Descent,
    support: Support,
    leading: int,
    start: np.ndarray,
    norm: Norm,
    weights: np.ndarray | None = None,
    **settings: float,
) -> Solved:
    """The fit of a support in a norm, from a start that is near.

    Args:
        weights: extra weights of the rows, in the measure of the mean; by default 1.
        settings: of `Descent.solve`.

    Raises `EcfitError` for a maximum norm of a head that is no quotient: use "l8".
    """
    measure = descent.root_w**2 if weights is None else descent.root_w**2 * weights
    measure = measure / measure.sum()
    if np.isinf(norm.power):
        least = settings.get("least", 0.0)
        return _programmed(descent, support, leading, start, norm, measure, least)

    def solve(w: np.ndarray, start: np.ndarray) -> Solved:
        return descent.solve(support, leading, start, root_w=np.sqrt(w / w.sum()), **settings)  # type: ignore[arg-type]

    solved = solve(measure, start)
    if norm.power == 2.0 and not norm.furnace:
        return solved
    return _reweighted(descent, support, leading, solved, norm, measure, solve)


def _residuals(
    descent: Descent, support: Support, leading: int, c: np.ndarray, norm: Norm
) -> tuple[np.ndarray, np.ndarray]:
    """|residual| of the norm, and its slope by e."""
    value = descent.value(support, leading, c)[0]
    if not norm.furnace:
        return np.abs(value - descent.target.values), np.ones_like(value)
    safe = np.maximum(value, 1e-6)
    return np.abs(descent.target.values / safe - 1.0), 1.0 / safe


def _size(r: np.ndarray, measure: np.ndarray, norm: Norm) -> float:
    if norm.ignored:
        order = np.argsort(r)
        inside = np.cumsum(measure[order]) <= 1.0 - norm.ignored
        return float(r[order][inside].max(initial=0.0))
    return float((measure @ r**norm.power) ** (1.0 / norm.power))


def _reweighted(
    descent: Descent,
    support: Support,
    leading: int,
    solved: Solved,
    norm: Norm,
    measure: np.ndarray,
    solve: Callable[[np.ndarray, np.ndarray], Solved],
) -> Solved:
    """Iteratively reweighted least squares; the best iterate in the norm itself."""
    best, steps = solved, solved.steps
    power = norm.power if norm.power <= 2.0 else 2.0
    r, slope = _residuals(descent, support, leading, solved.coefficients, norm)
    size, factor = _size(r, measure, norm), np.ones_like(r)
    for _ in range(_ROUNDS):
        power = min(norm.power, power * _RISE) if norm.power > 2.0 else norm.power
        scale = float(np.sqrt(measure @ r**2))
        if scale == 0.0:
            break
        u = np.maximum(r / scale, _FLOOR)
        if norm.ignored:
            order = np.argsort(r)
            inside = np.cumsum(measure[order]) <= 1.0 - norm.ignored
            u = np.minimum(u, u[order][inside].max())
        # The geometric mean with the last weights keeps high powers from jumping between two sets of peaks.
        factor = np.sqrt(factor * u ** (power - 2.0)) if norm.power > 2.0 else u ** (power - 2.0)
        new = solve(measure * factor * slope**2, solved.coefficients)
        if not np.all(np.isfinite(new.coefficients)):
            break
        solved, steps = new, steps + new.steps
        r, slope = _residuals(descent, support, leading, solved.coefficients, norm)
        found = _size(r, measure, norm)
        if found < size:
            settled = found > size * (1.0 - _SETTLED)
            best, size = solved, found
            if settled and power == norm.power:
                break
    rms = descent.rms(support, leading, best.coefficients)
    return best._replace(rms=rms, objective=size, steps=steps)


def _programmed(
    descent: Descent,
    support: Support,
    leading: int,
    start: np.ndarray,
    norm: Norm,
    measure: np.ndarray,
    least: float,
) -> Solved:
    if descent.affine is None:
        raise EcfitError(f"norm '{norm.name}' needs a head of one ratio: use 'l8' for '{descent.head.name}'")
    rows = measure > 0.0
    found = minimax(descent, support, leading, start, relative=norm.furnace, least=least, rows=rows)
    rms = descent.rms(support, leading, found.coefficients)
    return Solved(found.coefficients, rms, found.bound, found.converged, found.programs)
