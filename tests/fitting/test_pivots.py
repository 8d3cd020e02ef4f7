"""Pivots: what a sweep says of a subset is what solving for that subset gives."""

import itertools

import numpy as np
import pytest

from ecfit.fitting.pivots import Pivots

RNG = np.random.default_rng(5)
COLUMNS = RNG.normal(size=(40, 7))
COLUMNS /= np.linalg.norm(COLUMNS, axis=0)
TARGET = COLUMNS @ RNG.normal(size=7) + 0.3 * RNG.normal(size=40)
GRAM = np.c_[COLUMNS, TARGET].T @ np.c_[COLUMNS, TARGET]


def solved(inside: set[int]) -> tuple[np.ndarray, float]:
    """Coefficients of a subset, and the sum of squares that it leaves, by QR."""
    k = sorted(inside)
    c = np.zeros(7)
    if k:
        c[k] = np.linalg.lstsq(COLUMNS[:, k], TARGET, rcond=None)[0]
    return c, float(np.sum((COLUMNS @ c - TARGET) ** 2))


def of(inside: set[int]) -> Pivots:
    made = Pivots(GRAM)
    for k in inside:
        made.turn(k)
    return made


@pytest.mark.parametrize("inside", [set(), {3}, {0, 5}, {1, 2, 4, 6}, set(range(7))])
def test_coefficients_and_squares(inside):
    made = of(inside)
    c, squares = solved(inside)
    np.testing.assert_allclose(made.coefficients, c, atol=1e-12)
    assert made.squares == pytest.approx(squares)
    assert set(np.flatnonzero(made.inside)) == inside


def test_turning_twice_is_turning_back():
    made = of({1, 4})
    made.turn(2)
    made.turn(2)
    np.testing.assert_allclose(made.coefficients, of({1, 4}).coefficients, atol=1e-12)
    assert made.squares == pytest.approx(of({1, 4}).squares)


def test_gains_and_losses_are_what_turning_does():
    made = of({1, 4, 5})
    for k in range(7):
        other = made.copy()
        other.turn(k)
        if made.inside[k]:
            assert other.squares - made.squares == pytest.approx(made.losses()[k])
            assert made.gains()[k] < 0.0
        else:
            assert made.squares - other.squares == pytest.approx(made.gains()[k])
            assert np.isinf(made.losses()[k])


def test_the_best_exchange_is_the_best_of_all():
    made = of({0, 1, 2})
    gain, out, into = made.best_exchange()
    squares = {
        (i, j): solved({0, 1, 2} - {i} | {j})[1] for i, j in itertools.product((0, 1, 2), (3, 4, 5, 6))
    }
    best = min(squares, key=squares.__getitem__)
    assert (out, into) == best
    assert made.squares - gain == pytest.approx(squares[best])


def test_exchanges_end_where_none_lowers_the_sum():
    made = of({0, 1, 2})
    found = made.exchange(20)
    assert [s for s, _ in found] == sorted((s for s, _ in found), reverse=True)
    for squares, inside in found:
        assert squares == pytest.approx(solved(set(inside))[1])
    assert made.best_exchange()[0] <= 1e-3 * made.squares


def test_a_column_within_the_span_of_others_is_never_taken():
    columns = np.c_[COLUMNS[:, :3], (COLUMNS[:, 0] + COLUMNS[:, 1]) / 2.0]
    columns /= np.linalg.norm(columns, axis=0)
    rows = np.c_[columns, TARGET]
    made = Pivots(rows.T @ rows)
    made.turn(0)
    made.turn(1)
    assert made.gains()[3] == -1.0
    assert made.gains()[2] > 0.0
