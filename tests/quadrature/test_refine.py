"""Refinement: who climbs, who stops, and what each entry says of itself."""

import numpy as np
import pytest

from ecfit.quadrature import STATUS, Status, refine
from ecfit.quadrature.refine import in_blocks

# Errors of four rows of one entry by level: at once, at level 2, never, never a number.
ERRORS = np.array([[1e-9, 1e-3, 1e-2, np.nan], [1e-9, 1e-5, 1e-2, np.nan], [1e-9, 1e-9, 1e-2, np.nan]])
# Values that settle at 1; the last stays undefined.
VALUES = 1.0 + np.where(np.isnan(ERRORS), np.nan, ERRORS)

ONE = (1, 1)


def evaluate(level, index):
    return VALUES[level, index][:, None], ERRORS[level, index][:, None]


def test_each_entry_stops_at_the_first_level_that_meets_the_tolerance():
    asked: list[tuple[int, list[int]]] = []

    def noted(level, index):
        asked.append((level, index.tolist()))
        return evaluate(level, index)

    done = refine(noted, (4, 1), 3, 1e-7, confirm=False)
    assert asked == [(0, [0, 1, 2, 3]), (1, [1, 2, 3]), (2, [1, 2, 3])]
    assert done.level.tolist() == [0, 2, 2, 2]
    assert done.status[:, 0].tolist() == [
        Status.CONVERGED,
        Status.CONVERGED,
        Status.TOLERANCE_NOT_MET,
        Status.NOT_FINITE,
    ]
    np.testing.assert_array_equal(done.values[:3, 0], [1.0 + 1e-9, 1.0 + 1e-9, 1.01])
    assert np.isnan(done.values[3, 0])
    assert done.errors[3, 0] == np.inf


def test_errors_never_fall_below_rounding():
    done = refine(lambda level, index: (np.ones((1, 1)), np.zeros((1, 1))), ONE, 1, 1e-7, confirm=False)
    assert 1e-14 < done.errors[0, 0] < 1e-11


def test_confirmation_counts_the_change_from_the_level_before():
    values = [np.array([1.0]), np.array([1.5]), np.array([1.5 + 1e-8])]

    def confident(level, index):
        return values[level][:, None], np.array([[1e-12]])

    done = refine(confident, ONE, 3, 1e-7, confirm=True)
    assert done.level[0] == 2
    assert done.errors[0, 0] == pytest.approx(1e-8, rel=1e-3)
    assert refine(confident, ONE, 2, 1e-7, confirm=True).status[0, 0] == Status.TOLERANCE_NOT_MET
    assert refine(confident, ONE, 3, 1e-7, confirm=False).level[0] == 0


def test_confirmation_needs_two_levels():
    done = refine(lambda level, index: (np.ones((1, 1)), np.zeros((1, 1))), ONE, 1, 1e-7, confirm=True)
    assert done.status[0, 0] == Status.TOLERANCE_NOT_MET
    assert done.errors[0, 0] == np.inf


def test_an_infinite_integral_is_not_a_value():
    done = refine(
        lambda level, index: (np.full((1, 1), np.inf), np.zeros((1, 1))), ONE, 2, 1e-7, confirm=False
    )
    assert done.status[0, 0] == Status.NOT_FINITE


@pytest.mark.parametrize("tolerance", [1e-2, 1e-7, 1e-12])
def test_progress_adds_up_to_the_number_of_entries(tolerance):
    finished: list[int] = []
    refine(evaluate, (4, 1), 3, tolerance, confirm=False, progress=finished.append)
    assert sum(finished) == 4
    assert min(finished) >= 0


def test_a_row_climbs_until_all_its_entries_are_good():
    """Entries of a row share the geometry: there is nothing to save by leaving one behind."""
    asked: list[list[int]] = []

    def rows(level, index):
        asked.append(index.tolist())
        # Three rows of two entries: both at once, one at level 1, one never.
        error = np.array([[1e-9, 1e-9], [1e-9, 1e-3 if level == 0 else 1e-9], [1e-9, 1e-3]])
        return np.full((index.size, 2), float(level)), error[index]

    finished: list[int] = []
    done = refine(rows, (3, 2), 3, 1e-7, confirm=False, progress=finished.append)
    assert asked == [[0, 1, 2], [1, 2], [2]]
    assert done.level.tolist() == [0, 1, 2]
    # The good entry of the row that never ends is of the last level, and counts as converged.
    np.testing.assert_array_equal(done.values, [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])
    assert done.status.tolist() == [[Status.CONVERGED] * 2] * 2 + [
        [Status.CONVERGED, Status.TOLERANCE_NOT_MET]
    ]
    assert finished == [2, 2, 0, 2]


def test_every_status_has_words():
    assert set(STATUS) == set(Status)


# What the entries of a row differ in.
SCALES = np.array([1.0, 2.0, 5.0])


@pytest.mark.parametrize(("rows", "block"), [(10, 4), (8, 4), (3, 4), (1, 1)])
def test_blocks_have_one_size_and_give_what_one_call_gives(rows, block):
    sizes = set()

    def function(a, b):
        sizes.add(a.shape[0])
        return (a + b)[:, None] * SCALES, (a * b)[:, None] * SCALES

    a, b = np.arange(rows, dtype=float), np.arange(rows, dtype=float) ** 2
    total, product = in_blocks(function, [a, b], block, SCALES.size)
    assert sizes == {block}
    np.testing.assert_array_equal(total, (a + b)[:, None] * SCALES)
    np.testing.assert_array_equal(product, (a * b)[:, None] * SCALES)
