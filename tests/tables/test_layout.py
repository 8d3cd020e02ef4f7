"""The order of a file's numbers: every layout that others use comes back as the order of the axes."""

import numpy as np
import pytest

from ecfit.coordinates import Axis
from ecfit.errors import EcfitError
from ecfit.tables.layout import arranged

AXES = [Axis.spaced("F0", 2), Axis.spaced("r", 3), Axis.spaced("mu", 4)]
TABLE = np.arange(24.0).reshape(2, 3, 4)  # [F0, r, mu]
FASTEST_R = TABLE.transpose(0, 2, 1)  # [F0, mu, r]


@pytest.mark.parametrize(
    ("stored", "order"),
    [
        (TABLE, None),
        (TABLE.ravel(), None),
        (TABLE.reshape(6, 4), None),  # slices of F0 below each other
        (TABLE.reshape(2, 12), None),
        (TABLE.reshape(2, 1, 3, 4, 1), None),
        (FASTEST_R, ["F0", "mu", "r"]),
        (FASTEST_R.ravel(), ["F0", "mu", "r"]),
        (FASTEST_R.reshape(8, 3), ["F0", "mu", "r"]),
        (np.concatenate(list(TABLE), axis=1), ["r", "F0", "mu"]),  # slices side by side
        (TABLE.transpose(2, 1, 0), ["mu", "r", "F0"]),
        (TABLE[:, :, ::-1], ["F0", "r", "-mu"]),
        (TABLE.transpose(2, 1, 0)[::-1, ::-1], ["-mu", "-r", "F0"]),
    ],
)
def test_every_layout_comes_back(stored, order):
    np.testing.assert_array_equal(arranged(stored, AXES, order, "it"), TABLE)


@pytest.mark.parametrize(
    ("shape", "order", "words"),
    [
        (
            (2, 4, 3),
            None,
            r"2 x 4 x 3 numbers, expected F0 = 2 x r = 3 x mu = 4; order = \['F0', 'mu', 'r'\]",
        ),
        ((4, 6), None, r"order = \['mu', 'F0', 'r'\] would fit"),
        ((5, 5), None, "5 x 5 numbers.*check the counts"),
        ((3, 8), None, "would fit"),
        ((), None, "no list of numbers"),
        ((0,), None, "0 numbers"),
        ((2, 3, 4), ["F0", "r"], "each axis once"),
        ((2, 3, 4), ["F0", "r", "r"], "each axis once"),
        ((2, 3, 4), ["F0", "r", "nu"], "each axis once"),
        ((2, 3, 4), ["F0", "r", "--mu"], "each axis once"),
        ((2, 3, 4), "mu", "list of names"),
        ((2, 3, 4), [1, 2, 3], "list of names"),
    ],
)
def test_what_does_not_fit_is_told_with_what_would(shape, order, words):
    with pytest.raises(EcfitError, match=words):
        arranged(np.zeros(shape), AXES, order, "it")
