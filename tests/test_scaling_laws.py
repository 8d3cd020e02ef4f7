"""The laws of benchmarks/scaling.py: found again where they hold, and their deviations told."""

import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def laws():
    """benchmarks/scaling_laws.py."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        import scaling_laws
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))
    return scaling_laws


def test_a_line_is_found_over_decades(laws):
    x = np.array([1e2, 1e4, 1e6])
    law = laws.line(x, 0.02 + 3e-6 * x)
    np.testing.assert_allclose(law.coefficients, (0.02, 3e-6), rtol=1e-9)
    assert law.deviation < 1e-9
    assert law.r2 == pytest.approx(1.0)


def test_a_time_is_never_negative(laws):
    """Noise would put the constant below 0: it is 0, and the slope the best without it."""
    law = laws.line([100.0, 200.0], [1.0, 2.2])
    assert law.coefficients[0] == 0.0
    assert 0.010 < law.coefficients[1] < 0.011


def test_the_deviation_is_the_largest(laws):
    x = np.array([1.0, 2.0, 4.0, 8.0])
    law = laws.power(x**2 * np.array([1.0, 1.0, 1.3, 1.0]), x)
    predicted = law.coefficients[0] * x ** law.coefficients[1]
    assert law.deviation == pytest.approx(1.3 * 16.0 / predicted[2] - 1.0)
    assert 0.9 < law.r2 < 1.0


def test_a_power_law_of_two_sizes_is_found(laws):
    rows, columns = np.array([10.0, 100.0, 10.0, 100.0]), np.array([2.0, 2.0, 8.0, 8.0])
    law = laws.power(5e-9 * rows * columns**1.5, rows, columns)
    np.testing.assert_allclose(law.coefficients, (5e-9, 1.0, 1.5), rtol=1e-9)
