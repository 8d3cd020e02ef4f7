"""Figures show what they say: a line for each technique, with its values."""

import numpy as np

import ecfit
from ecfit.report.sampling import weights_over_angle, weights_over_roughness
from ecfit.sampling import technique


def test_weights_over_the_angle():
    made = weights_over_angle(ecfit.model("eon"), {"uniform": technique("uniform")}, 0.0, count=3)
    (variance,) = made.axes[0].get_lines()
    np.testing.assert_allclose(np.asarray(variance.get_ydata()), 1.0 / 3.0, atol=1e-3)  # of a Lambertian
    assert [a.get_title() for a in made.axes][2] == "mean weight"


def test_weights_over_roughness():
    made = weights_over_roughness(ecfit.model("eon"), {"cosine": technique("cosine")}, [0.5, 1.0], count=2)
    first, second = made.axes[0].get_lines()
    assert np.asarray(second.get_ydata())[1] > np.asarray(first.get_ydata())[1]
