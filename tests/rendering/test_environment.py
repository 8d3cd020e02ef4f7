"""The light of the colour pictures."""

import numpy as np

from ecfit.rendering.environment import HEIGHT, WIDTH, studio


def test_it_is_an_image_of_finite_radiance():
    light = studio()
    assert light.shape == (HEIGHT, WIDTH, 3)
    assert light.dtype == np.float32
    assert np.all(np.isfinite(light))
    assert light.min() > 0.0


def test_it_joins_at_the_back_and_is_brighter_above():
    light = studio()
    seam, steps = np.abs(light[:, 0] - light[:, -1]), np.abs(np.diff(light, axis=1))
    assert seam.max() <= steps.max()
    assert light[: HEIGHT // 2].mean() > 2.0 * light[HEIGHT // 2 :].mean()


def test_it_has_a_lamp_whose_reflection_can_be_seen():
    light = studio().mean(axis=-1)
    assert light.max() > 8.0 * np.median(light)
    assert (light > 0.5 * light.max()).mean() < 0.05
