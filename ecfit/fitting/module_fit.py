"""Fits of modules: Levenberg-Marquardt on the numbers of any Equinox module.

As in `solver.py`, Optimistix sees the residual r and its Jacobian J only through a small equivalent problem;
here it is the triangle of a QR factorisation of [J r], gathered over blocks of rows, which keeps the digits
of badly conditioned modules. Steps to values or derivatives that are not finite are refused. Poles of modules
are unknown (see `ModuleFormula.smallest_denominator`), and "converged" says nothing of them, unless the
module tells its denominator: then it is kept positive on the nodes and, by a penalty, on guards between them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import lineax as lx
import numpy as np
import optimistix as optx

from ecfit._jax import jax, jnp
from ecfit.approximation import Approximation
from ecfit.approximation.module import ModuleFormula
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError
from ecfit.fitting.result import Fit, judged
from ecfit.fitting.samples import weights_of
from ecfit.fitting.weights import entry_weights
from ecfit.forms.modules import (
    ModuleForm,
    checked,
    coefficients_of,
    coordinates_of_module,
    degree_of,
    evaluated,
    with_coefficients,
)
from ecfit.tables import Table

_RTOL = 1e-8
_STEPS = 400
# Residual reported for a refused step: far above any true one, far from overflow.
_REFUSED = 1e6
# Guards an axis, and where a module's denominator is penalised, in units of its mean at the start; there a
# guard weighs as much as a residual of 0.1 (as in descent.py).
_GUARDS = {1: 257, 2: 33, 3: 13}
_LEAST_Q = 1e-5
_GUARDED_Q = 2e-3
_GUARD_WEIGHT = 0.1 / _GUARDED_Q
# Rounds of guarding the place of a pole that was found between the guards.
_WATCHES = 6
# Rows a block, less for many coefficients: a block's Jacobian then takes 8 MB at most.
_BLOCK_NUMBERS = 1_000_000


def fit_module(
    table: Table,
    form: ModuleForm,
    *,
    name: str | None = None,
    max_steps: int | None = None,
    digits: int | None = None,
    weights: Any = None,
) -> Fit:
    """Fit a module to a table by weighted least squares; see `ecfit.fit` for the arguments."""
    module = started(form.module(), table)
    names = coordinates_of_module(module, table.names)
    start = coefficients_of(module)
    if not 1 <= start.size <= table.values.size:
        raise EcfitError(
            f"{form.name} has {start.size} coefficients, the table {table.values.size} entries: a module "
            "needs 1 or more, inexact arrays (jnp.array, not float), and no more than entries"
        )
    points = _points(table, names)
    make = with_coefficients(module)
    problem = _Problem(
        lambda c, x: evaluated(make(c), names, x),
        _denominator(module, make, names),
        points,
        table.values.ravel(),
        _measure(table, weights, start.size),
        names,
    )
    domain = _domain(table, names)
    guards = _guards(domain)
    descend = _descent(problem, start, guards, _STEPS if max_steps is None else max_steps)
    steps, watched = 0, 0
    while True:
        found, converged, more = descend(guards)
        fitted, steps = make(jnp.asarray(found)), steps + more
        smallest = ModuleFormula(fitted, names).smallest_denominator(domain)
        if smallest.bound > 0.0 or problem.denominator is None or watched == _WATCHES:
            break
        # A pole between the guards: watch the place and descend again.
        watched += 1
        guards[-watched] = smallest.place
    if digits is not None:
        fitted = make(jnp.asarray([float(f"{c:.{digits}g}") for c in found]))
    approximation = Approximation(
        name=name or f"{form.name} {degree_of(fitted)}",
        form=form.name,
        degree=degree_of(fitted),
        variables=names,
        formula=ModuleFormula(fitted, names, form.record(fitted, names)),
        domain=domain,
        contract=table.contract,
    )
    return judged(approximation, table, converged, steps, 1)


@dataclass(frozen=True)
class _Problem:
    """What is fitted: functions of (coefficients, points), and a table's entries, flat."""

    value: Callable[[Any, Sequence[Any]], Any]
    denominator: Callable[[Any, Sequence[Any]], Any] | None
    points: Sequence[np.ndarray]
    values: np.ndarray
    measure: np.ndarray
    names: Sequence[str]


def _denominator(module: Any, make: Callable, names: Sequence[str]) -> Callable | None:
    if getattr(module, "denominator", None) is None:
        return None
    return lambda c, x: make(c).denominator(**dict(zip(names, x, strict=True)))


def _guards(domain: Sequence[tuple[float, float]]) -> np.ndarray:
    """Points over a domain, clustered towards its ends, and room for more; shape (points, coordinates)."""
    count = _GUARDS.get(len(domain), 5)
    t = 0.5 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, count)))
    mesh = np.meshgrid(*(low + (high - low) * t for low, high in domain), indexing="ij")
    points = np.stack([m.ravel() for m in mesh], axis=1)
    return np.concatenate([points, np.repeat(points[-1:], _WATCHES, axis=0)])


def started(module: eqx.Module, table: Table) -> eqx.Module:
    """The module with its own start for a table, where it has a `started` method."""
    own = getattr(module, "started", None)
    return module if own is None else checked(own(table), f"{type(module).__name__}.started(table)")


def _points(table: Table, names: Sequence[str]) -> list[np.ndarray]:
    mesh = np.meshgrid(*(a.nominal for a in table.axes), indexing="ij")
    found = resolve(names, dict(zip(table.names, mesh, strict=True)))
    return [np.asarray(found[n], dtype=np.float64).ravel() for n in names]


def _domain(table: Table, names: Sequence[str]) -> tuple[tuple[float, float], ...]:
    ends = [resolve(names, {a.name: float(getattr(a, e)) for a in table.axes}) for e in ("low", "high")]
    return tuple((float(ends[0][n]), float(ends[1][n])) for n in names)


def _measure(table: Table, weights: Any, count: int) -> np.ndarray:
    measure = np.ones(1)
    for axis in table.axes:
        measure = np.multiply.outer(measure, weights_of(axis))
    given = entry_weights(table, weights, count)
    measure = measure.ravel() if given is None else measure.ravel() * given
    return measure / measure.sum()


def _descent(
    problem: _Problem, start: np.ndarray, guards: np.ndarray, max_steps: int
) -> Callable[[np.ndarray], tuple[np.ndarray, bool, int]]:
    """A function of the guards (as many as these), compiled once.

    It gives the coefficients of the least weighted sum of squares, whether the solver converged, its steps.
    """
    n, value, denominator = start.size, problem.value, problem.denominator
    size = max(min(len(problem.values), _BLOCK_NUMBERS // n), n)
    rows = [_blocks(a, size) for a in (np.stack(problem.points, axis=1), problem.values)]
    # Padding repeats the last row without weight.
    filled = rows[1].size - len(problem.values)
    rows.append(np.pad(np.sqrt(problem.measure), (0, filled)).reshape(rows[1].shape))
    unit = 1.0
    if denominator is not None:
        unit = float(np.mean(np.abs(denominator(jnp.asarray(start), [jnp.asarray(g) for g in guards.T]))))

    def block(c, row):
        x, f, w = row
        predicted, push = jax.linearize(lambda c: value(c, list(x.T)), c)
        jacobian = jax.vmap(push)(jnp.eye(n)).T
        return jnp.concatenate([jacobian * w[:, None], (w * (predicted - f))[:, None]], axis=1)

    def penalties(c, guards):
        assert denominator is not None
        divisor = denominator
        q, push = jax.linearize(lambda c: divisor(c, list(guards.T)) / unit, c)
        low = jnp.where(q < _GUARDED_Q, _GUARD_WEIGHT / len(guards) ** 0.5, 0.0)
        made = jnp.concatenate([jax.vmap(push)(jnp.eye(n)).T, (q - _GUARDED_Q)[:, None]], axis=1)
        made = jnp.concatenate([jnp.zeros((n + 1, n + 1)), made * low[:, None]])
        return jnp.linalg.qr(jnp.where(jnp.isfinite(made), made, 0.0), mode="r")

    def triangle(c, rows, guards):
        def add(carry, row):
            r, fine = carry
            made = block(c, row)
            finite = jnp.all(jnp.isfinite(made))
            if denominator is not None:
                finite &= jnp.min(denominator(c, list(row[0].T))) > _LEAST_Q * unit
            made = jnp.where(finite, made, 0.0)
            return (jnp.linalg.qr(jnp.concatenate([r, made]), mode="r"), fine & finite), None

        first = penalties(c, guards) if denominator is not None else jnp.zeros((n + 1, n + 1))
        return jax.lax.scan(add, (first, jnp.asarray(True)), tuple(rows))[0]

    first, fine = jax.jit(triangle)(start, rows, guards)
    if not fine:
        _explain(problem, start)
    # The solver's damping knows no scale of its own: columns of the Jacobian get norm 1 at the start.
    norms = np.linalg.norm(np.asarray(first)[:, :-1], axis=0)
    scale = 1.0 / np.where(norms > 1e-12 * norms.max(), norms, max(float(norms.max()), 1e-300))

    @jax.jit
    def solve(z0, rows, guards, scale):
        def root(z):
            r, fine = triangle(z * scale, rows, guards)
            return jnp.where(fine, r[:, -1], _REFUSED), r[:, :-1] * scale

        @jax.custom_jvp
        def residual(z):
            return root(z)[0]

        @residual.defjvp
        def _(primals, tangents):
            value, jacobian = root(primals[0])
            return value, jacobian @ tangents[0]

        solver = optx.LevenbergMarquardt(rtol=_RTOL, atol=1e-13, linear_solver=lx.QR())
        solution = optx.least_squares(lambda z, _: residual(z), solver, z0, max_steps=max_steps, throw=False)
        return solution.value, solution.result == optx.RESULTS.successful, solution.stats["num_steps"]

    def descend(guards: np.ndarray) -> tuple[np.ndarray, bool, int]:
        z, converged, steps = solve(start / scale, rows, guards, scale)
        return np.asarray(z) * scale, bool(converged), int(steps)

    return descend


def _blocks(array: np.ndarray, size: int) -> np.ndarray:
    """Rows in blocks of one size, the last one filled up with the last row."""
    more = -len(array) % size
    filled = np.concatenate([array, np.repeat(array[-1:], more, axis=0)])
    return filled.reshape(-1, size, *array.shape[1:])


def _explain(problem: _Problem, start: np.ndarray) -> None:
    """Raise `EcfitError` with the place where the start is not finite."""
    value, x = problem.value, [jnp.asarray(p) for p in problem.points]
    rows = np.asarray(value(jnp.asarray(start), x))[:, None]
    what = "the value"
    if np.all(np.isfinite(rows)):
        rows, what = np.asarray(jax.jacfwd(value)(jnp.asarray(start), x)), "a derivative by the coefficients"
    fine = np.isfinite(rows).all(axis=1)
    if fine.all():
        raise EcfitError("the module's denominator is not positive at its start: begin where it is")
    i = int(np.argmin(fine))
    place = ", ".join(f"{n} = {p[i]:.4g}" for n, p in zip(problem.names, problem.points, strict=True))
    raise EcfitError(
        f"{what} of the module is not finite at {place}: guard its divisions, powers and logarithms there"
    )
