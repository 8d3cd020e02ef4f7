"""Levenberg-Marquardt for structured forms: any head, any number of ratios over one denominator.

As in `solver.py`, Optimistix sees the residual r and its Jacobian J only through J'J, J'r and r'r, handed
over as an equivalent problem with one row a coefficient. A step into Q <= 0 on the rows is refused; at
guards it is penalised.
"""

from functools import cached_property, partial
from typing import NamedTuple

import equinox as eqx
import numpy as np
import optimistix as optx

from ecfit._jax import jax, jnp
from ecfit.expressions.evaluate import JAX, evaluate
from ecfit.expressions.rounding import UNIT
from ecfit.fitting.bounded import BoundedLevenbergMarquardt
from ecfit.forms.heads import Head

Array = jax.Array

# Residual reported for a refused step: far above any true one, far from overflow.
REFUSED = 1e6
# Q's leading term has the mean 1 over the rows: below this Q counts as a pole, and below the second it is
# penalised at the guards.
_LEAST_Q = 1e-5
_GUARDED_Q = 2e-3
# A guard where Q vanishes then weighs as much as a residual of 0.1 at one of as many rows: more than any fit
# is worth.
_GUARD_WEIGHT = 0.1 / _GUARDED_Q
# Damping begins at 1, which is much for residuals of 1e-4, and falls by the default factor of 3.5 only where
# a step's prediction is right to 1 %: most of 50 steps would go by before it is small. In this unit of the
# residual, and with these factors, 10 steps do.
_UNIT = 100.0
_TRUST = {"high_cutoff": 0.75, "high_constant": 10.0, "low_constant": 0.1}
# Rounds of the linearised start: it settles in a few or not at all.
_LINEARISED = 12
# A column whose square is less than this part outside the span of the others adds nothing.
_DEPENDENT = 1e-11
# The largest rounding error of our fits in single precision, over 20,000 points, is about this part of the
# sum of all terms' sizes, times the unit roundoff: terms are nested, and errors cancel.
_LOST = 0.2
# Coefficients are padded to a multiple of this, so that few shapes are compiled.
_PAD = 8


class Rows(NamedTuple):
    """What a head needs at some points: everything but the ratios. Arrays of shape (rows,).

    Attributes:
        factors: of each ratio, shape (ratios, rows): X_i = factors[i] P_i' / Q'; at guards X_i / shared for
            each of `Head.held`, shape (held, ratios, rows).
        data: features that the head's formulas name, in the order of `Head.inputs`, shape (names, rows).
    """

    factors: np.ndarray
    data: np.ndarray


class Target(NamedTuple):
    """Rows to be fitted: points, values, weights (of squares), all of shape (rows,)."""

    rows: Rows
    values: np.ndarray
    weights: np.ndarray


class Pairs(NamedTuple):
    """Pairs of points at which the value should not fall from the first to the second.

    Attributes:
        rows, columns: of all points, as those of a target.
        low, high: indices of the points of each pair.
    """

    rows: Rows
    columns: list[np.ndarray]
    low: np.ndarray
    high: np.ndarray


class Solved(NamedTuple):
    """Coefficients, the weighted RMS residual with and without penalties, whether it converged, steps."""

    coefficients: np.ndarray
    rms: float
    objective: float
    converged: bool
    steps: int


def _evaluated(head, formula, x, data):
    """A formula of a head at products x (ratios, rows) and features data (names, rows), shape (rows,)."""
    table = {**dict(zip(head.symbols, x, strict=True)), **dict(zip(head.inputs, data, strict=True))}
    return evaluate([formula], table, JAX, lambda c: c)[0] * jnp.ones(x.shape[1])


def _slopes_of(function, x):
    """Slopes of a function of x (ratios, rows), which takes each row by itself, by each ratio."""
    unit = [jnp.zeros_like(x).at[i].set(1.0) for i in range(x.shape[0])]
    return jnp.stack([jax.jvp(function, (x,), (u,))[1] for u in unit])


@partial(jax.jit, static_argnames="head")
def _descend(
    z0, columns, q0, rows, values, root_w, guards, guard_q0, guard_rows, groups, rtol, strength, least,
    ridge, max_steps, pairs=None, *, head,
):  # fmt: skip
    """Minimise; `columns` and `guards` are scaled so that their coefficients are of order 1."""

    def evaluated(formula, x, data):
        return _evaluated(head, formula, x, data)

    def sums(z, columns, q0):
        s = (columns * z) @ groups
        return s[:, :-1].T, q0 + s[:, -1]

    def jacobian(columns, slopes, ratios, q):
        """Columns of d value / dz from the slopes d value / d ratio, shape (ratios, rows)."""
        inner = jnp.concatenate([slopes, -jnp.sum(slopes * ratios, axis=0)[None]], axis=0) / q
        return columns * (groups @ inner).T

    def root(z):
        p, q = sums(z, columns, q0)
        ratios = p / q
        x = rows.factors * ratios

        def f(x):
            return evaluated(head.value, x, rows.data)

        slopes = _slopes_of(f, x) * rows.factors
        r = (f(x) - values) * root_w
        block = jnp.concatenate([jacobian(columns, slopes, ratios, q) * root_w[:, None], r[:, None]], axis=1)
        gram = block.T @ block
        gp, gq = sums(z, guards, guard_q0)
        # Soft at the guards: a refusal there would end descents at the first touch of the boundary.
        low = jnp.where(gq < _GUARDED_Q, _GUARD_WEIGHT * strength, 0.0)
        block = jnp.concatenate(
            [guards * groups[:, -1] * low[:, None], (low * (gq - _GUARDED_Q))[:, None]], axis=1
        )
        gram = gram + block.T @ block
        gq = jnp.maximum(gq, _GUARDED_Q)
        gratios = gp / gq
        for held, factors in zip(head.held, guard_rows.factors, strict=True):
            gx = factors * gratios
            d = partial(evaluated, held.rest, data=guard_rows.data)
            low = d(gx)
            slopes = _slopes_of(d, gx) * factors
            on = jnp.where(low < least, strength, 0.0)
            jac = jacobian(guards, slopes, gratios, gq) * on[:, None]
            block = jnp.concatenate([jac, (on * (low - least))[:, None]], axis=1)
            gram = gram + block.T @ block
        if pairs is not None:
            # Differences of the value between the points of pairs, where they are below 0.
            columns_, q0_, rows_, low, high, weight = pairs
            pp, pq = sums(z, columns_, q0_)
            pq = jnp.maximum(pq, _GUARDED_Q)
            px = rows_.factors * (pp / pq)

            def at_pairs(x):
                return evaluated(head.value, x, rows_.data)

            slopes = _slopes_of(at_pairs, px) * rows_.factors
            found, jac = at_pairs(px), jacobian(columns_, slopes, pp / pq, pq)
            fall = found[high] - found[low]
            on = jnp.where(fall < 0.0, weight, 0.0)
            block = jnp.concatenate([(jac[high] - jac[low]) * on[:, None], (on * fall)[:, None]], axis=1)
            gram = gram + block.T @ block
        n = z.shape[0]
        gram = gram + ridge**2 * jnp.pad(jnp.eye(n), (0, 1))
        gram = gram.at[:n, n].add(ridge**2 * z).at[n, :n].add(ridge**2 * z).at[n, n].add(ridge**2 * (z @ z))
        eigenvalues, vectors = jnp.linalg.eigh(gram)
        s = jnp.sqrt(jnp.maximum(eigenvalues, 0.0))[:, None] * vectors.T
        return jnp.where(jnp.min(q) > _LEAST_Q, s[:, -1], REFUSED), s[:, :-1]

    @jax.custom_jvp
    def residual(z):
        return root(z)[0]

    @residual.defjvp
    def _(primals, tangents):
        value, jac = root(primals[0])
        return value, jac @ tangents[0]

    solver = eqx.tree_at(
        lambda s: s.search,
        BoundedLevenbergMarquardt(rtol, 1e-13, max_steps),
        optx.ClassicalTrustRegion(**_TRUST),
    )
    solution = optx.least_squares(lambda z, _: _UNIT * residual(z), solver, z0, max_steps=None, throw=False)
    z = solution.value
    p, q = sums(z, columns, q0)
    r = (evaluated(head.value, rows.factors * p / q, rows.data) - values) * root_w
    objective = jnp.sqrt(jnp.sum(residual(z) ** 2))
    converged = solution.result == optx.RESULTS.successful
    return z, jnp.sqrt(r @ r), objective, converged, solution.stats["num_steps"]


class Descent:
    """Levenberg-Marquardt over any choice of candidate columns of one target.

    Args:
        head: the form's head.
        target, columns: rows to be fitted and the candidate terms there, one array (rows, terms) a numerator
            and Q.
        guards, guard_columns: points where Q > 0 and the head's limits are held.

    `pairs`, where they are set, are held monotone by a penalty: `pair_weight` times the RMS fall over them.
    """

    def __init__(
        self,
        head: Head,
        target: Target,
        columns: list[np.ndarray],
        guards: Rows,
        guard_columns: list[np.ndarray],
    ) -> None:
        self.head: Head = head
        self.target: Target = target
        self.guards: Rows = guards
        self.columns: list[np.ndarray] = columns
        self.guard_columns: list[np.ndarray] = guard_columns
        self.root_w: np.ndarray = np.sqrt(target.weights / target.weights.sum())
        self.pairs: Pairs | None = None
        self.pair_weight: float = 1.0

    def solve(
        self,
        support: list[list[int]],
        leading: int,
        start: np.ndarray,
        *,
        rtol: float = 1e-4,
        max_steps: int = 60,
        strength: float = 1.0,
        least: float = 0.0,
        ridge: float = 0.0,
        root_w: np.ndarray | None = None,
    ) -> Solved:
        """Minimise from `start`: coefficients of the support's columns, group after group.

        Args:
            support: indices of columns, for each numerator and for Q (without its leading term).
            leading: index of Q's term with the coefficient 1.
            strength: weight of what the head holds, where it is below `least` at the guards.
            ridge: weight of the coefficients' sizes, relative to their columns' scale.
            root_w: roots of the rows' weights, by default those of the target.
        """
        x = np.concatenate([c[:, s] for c, s in zip(self.columns, support, strict=True)], axis=1)
        g = np.concatenate([c[:, s] for c, s in zip(self.guard_columns, support, strict=True)], axis=1)
        n = x.shape[1]
        padded = -(-n // _PAD) * _PAD
        norms = np.sqrt(np.mean(x**2, axis=0))
        q0, gq0 = self.columns[-1][:, leading], self.guard_columns[-1][:, leading]
        unit = float(np.mean(np.abs(q0)))
        # One scale a column, and Q of order 1; P and Q share the unit.
        norms = np.where(norms > 0.0, norms, 1.0) / unit
        groups = np.zeros((padded, len(support)))
        groups[np.arange(n), np.repeat(np.arange(len(support)), [len(s) for s in support])] = 1.0
        widen = [(0, 0), (0, padded - n)]
        z, rms, objective, converged, steps = _descend(
            np.pad(start * norms, (0, padded - n)),
            np.pad(x / (norms * unit), widen),
            q0 / unit,
            self.target.rows,
            self.target.values,
            self.root_w if root_w is None else root_w,
            np.pad(g / (norms * unit), widen),
            gq0 / unit,
            self.guards,
            groups,
            rtol,
            strength / np.sqrt(len(gq0)),
            least,
            ridge,
            max_steps,
            self._pairs(support, leading, norms, unit, padded),
            head=self.head,
        )
        return Solved(np.asarray(z)[:n] / norms, float(rms), float(objective), bool(converged), int(steps))

    def _pairs(
        self, support: list[list[int]], leading: int, norms: np.ndarray, unit: float, padded: int
    ) -> tuple | None:
        """The pairs as `_descend` takes them: scaled, padded, with their weight."""
        if self.pairs is None:
            return None
        rows, columns, low, high = self.pairs
        x = np.concatenate([c[:, s] for c, s in zip(columns, support, strict=True)], axis=1)
        scaled = np.pad(x / (norms * unit), [(0, 0), (0, padded - x.shape[1])])
        return scaled, columns[-1][:, leading] / unit, rows, low, high, self.pair_weight / np.sqrt(len(low))

    def least_difference(self, support: list[list[int]], leading: int, c: np.ndarray) -> float:
        """The least growth of the value over all pairs: below 0 it falls."""
        assert self.pairs is not None
        value = self._value(self.pairs.columns, self.pairs.rows, support, leading, c)[0]
        return float(np.min(value[self.pairs.high] - value[self.pairs.low]))

    @cached_property
    def affine(self) -> tuple[np.ndarray, np.ndarray] | None:
        """(base, slope) at the rows where the value is base + slope P' / Q'; nothing for other heads."""
        if self.head.ratios > 1:
            return None
        rows = self.target.rows
        found = [slopes_at(x * np.ones_like(rows.factors), rows.data, head=self.head) for x in (0.0, 1.0)]
        (base, slope), (_, other) = ((np.asarray(v), np.asarray(s)[0]) for v, s in found)
        return (base, slope * rows.factors[0]) if np.array_equal(slope, other) else None

    def linearised(self, support: list[list[int]], leading: int) -> np.ndarray | None:
        """A start by Sanathanan & Koerner 1963: the residual times Q / (the last Q) is linear.

        The best iterate with Q > 0 on the rows and guards; nothing where none is, or the head is not affine.
        """
        if self.affine is None:
            return None
        base, slope = self.affine
        p, q = (x[:, s] for x, s in zip(self.columns, support, strict=True))
        q0, guard_q0 = self.columns[-1][:, leading], self.guard_columns[-1][:, leading]
        guards = self.guard_columns[-1][:, support[1]]
        y = self.target.values - base
        a = np.concatenate([p * slope[:, None], -q * y[:, None]], axis=1)
        # As below: Q's leading term alone may vanish at some rows.
        weight, best, out = self.root_w / np.maximum(q0, 1e-2 * q0.mean()), np.inf, None
        for _ in range(_LINEARISED):
            rows = a * weight[:, None]
            norms = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
            rows /= norms
            # The ridge keeps the normal equations solvable; the start need not be exact.
            gram = rows.T @ rows + 1e-12 * np.eye(rows.shape[1])
            c = np.linalg.solve(gram, rows.T @ (y * q0 * weight)) / norms
            new = q0 + q @ c[p.shape[1] :]
            if new.min() > 0.0 and (guard_q0 + guards @ c[p.shape[1] :]).min() > 0.0:
                rms = float(np.linalg.norm(self.root_w * (slope * (p @ c[: p.shape[1]]) / new - y)))
                if rms < best * 0.999:
                    best, out = rms, c
                elif out is not None:
                    break
            new = np.maximum(np.abs(new), 1e-2 * np.abs(new).mean())
            weight = self.root_w / new
        return out

    def least_q(self, support: list[list[int]], leading: int, c: np.ndarray) -> float:
        """The least Q at the rows and guards."""
        own = c[len(c) - len(support[-1]) :]
        tables = (self.columns[-1], self.guard_columns[-1])
        return float(min((x[:, leading] + x[:, support[-1]] @ own).min() for x in tables))

    def rounding(self, support: list[list[int]], leading: int, c: np.ndarray) -> float:
        """An estimate of the largest rounding error in single precision at the rows.

        Terms that cancel, in P as in Q, are what loses digits: sizes are those of all terms together.
        """
        _, slopes, ratios, q = self.value(support, leading, c)
        parts = np.split(np.abs(c), np.cumsum([len(s) for s in support])[:-1])
        sizes = [np.abs(x[:, s]) @ k for x, s, k in zip(self.columns, support, parts, strict=True)]
        sizes[-1] += np.abs(self.columns[-1][:, leading])
        lost = np.sum(np.abs(slopes) * (np.stack(sizes[:-1]) + np.abs(ratios) * sizes[-1]) / q, axis=0)
        return _LOST * UNIT * float(lost.max())

    def rms(self, support: list[list[int]], leading: int, c: np.ndarray) -> float:
        """Weighted RMS residual; infinite where Q <= 0 at a row or guard."""
        if self.least_q(support, leading, c) <= 0.0:
            return np.inf
        value = self.value(support, leading, c)[0]
        return float(np.linalg.norm((value - self.target.values) * self.root_w))

    def value(self, support: list[list[int]], leading: int, c: np.ndarray) -> tuple[np.ndarray, ...]:
        """The value at the rows, its slopes by the ratios (ratios, rows), the ratios, and Q."""
        return self._value(self.columns, self.target.rows, support, leading, c)

    def _value(self, columns, rows, support, leading, c):
        ends = np.cumsum([len(s) for s in support])[:-1]
        parts = [x[:, s] @ k for x, s, k in zip(columns, support, np.split(c, ends), strict=True)]
        q = columns[-1][:, leading] + parts[-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = np.stack(parts[:-1]) / q
        value, slopes = slopes_at(rows.factors * ratios, rows.data, head=self.head)
        return np.asarray(value), np.asarray(slopes) * rows.factors, ratios, q

    def jacobian(
        self, support: list[list[int]], leading: int, c: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Value, what multiplies a column of each group in the weighted Jacobian, and that of the support."""
        value, slopes, ratios, q = self.value(support, leading, c)
        inner = np.concatenate([slopes, -np.sum(slopes * ratios, axis=0)[None]]) / q * self.root_w
        groups = zip(self.columns, support, inner, strict=True)
        return value, inner, np.concatenate([x[:, s] * row[:, None] for x, s, row in groups], axis=1)

    def gains(self, support: list[list[int]], leading: int, c: np.ndarray) -> list[np.ndarray]:
        """First-order gain of each candidate column: the part of the sum of squares it would take away."""
        value, inner, jac = self.jacobian(support, leading, c)
        r = (value - self.target.values) * self.root_w
        jac = jac / np.maximum(np.linalg.norm(jac, axis=0), 1e-300)
        basis = np.linalg.qr(jac)[0]
        r = r - basis @ (basis.T @ r)
        out = []
        for x, square, row, s in zip(self.columns, self._squares, inner, support, strict=True):
            # |z|^2, Q'z and r'z of all columns z = x row, without forming them.
            size = row**2 @ square
            rest = size - np.sum(np.square((basis * row[:, None]).T @ x), axis=0)
            with np.errstate(all="ignore"):
                gain = np.where(rest > _DEPENDENT * size, ((r * row) @ x) ** 2 / rest, 0.0)
            gain[list(s)] = -1.0
            out.append(gain)
        out[-1][leading] = -1.0
        return out

    @cached_property
    def _squares(self) -> list[np.ndarray]:
        return [x**2 for x in self.columns]

    def losses(self, support: list[list[int]], leading: int, c: np.ndarray) -> np.ndarray:
        """First-order loss of removing each coefficient: growth of the sum of squares."""
        _, _, jac = self.jacobian(support, leading, c)
        norms = np.maximum(np.linalg.norm(jac, axis=0), 1e-300)
        triangle = np.linalg.qr(jac / norms, mode="r")
        inverse = np.linalg.pinv(triangle)
        return (c * norms) ** 2 / np.sum(inverse**2, axis=1)


@partial(jax.jit, static_argnames=("head", "held"))
def slopes_at(x, data, *, head, held=-1):
    """Value of a head (or `held`, an index of what it holds) at products X, and its slopes by each."""
    formula = head.value if held < 0 else head.held[held].rest

    def f(x):
        return _evaluated(head, formula, x, data)

    return f(x), _slopes_of(f, x)
