"""Numbers from pictures whose deviation and noise are known."""

import numpy as np
import pytest

from ecfit.rendering.verdict import LEAST_MU, RINGS, verdict


def picture(deviation, noise: float = 0.0, size: int = 200, seeds: int = 8) -> dict[str, np.ndarray]:
    """What a renderer would return for a sphere of radius 1 in [-1, 1]^2 with a deviation of mu."""
    x = np.linspace(-1.0, 1.0, size)
    mu = np.sqrt(np.maximum(1.0 - x[:, None] ** 2 - x**2, 0.0))
    draws = 1.0 + deviation(mu) + noise * np.random.default_rng(5).standard_normal((seeds, size, size))
    return {
        "inside": (mu >= LEAST_MU).astype(float),
        "value": draws.mean(axis=0),
        "variance": draws.var(axis=0, ddof=1) / seeds,
        "mu": mu,
        "rest": np.full_like(mu, 0.25),
    }


def test_a_constant_deviation_is_mean_worst_and_energy():
    found = verdict(picture(lambda mu: -0.03 + 0.0 * mu))
    assert (found.mean, found.worst, found.energy) == pytest.approx((0.03, 0.03, -0.03), rel=1e-12)
    assert found.noise < 1e-15
    assert found.rest == 0.25


def test_the_sphere_is_seen_from_the_front():
    """Over a disc mu has the density 2 mu: 1 / 3 of [0, 1] in mu is 1 / 9 of the picture."""
    found = verdict(picture(lambda mu: 0.09 * (mu < 1.0 / 3.0)))
    assert found.energy == pytest.approx(0.09 * (1.0 / 9.0 - LEAST_MU**2) / (1.0 - LEAST_MU**2), rel=0.02)
    assert found.worst == pytest.approx(0.09)
    assert found.worst_mu < 1.0 / 3.0
    assert len(found.mu) == RINGS


def test_losses_and_gains_do_not_cancel_in_the_mean():
    found = verdict(picture(lambda mu: np.where(mu**2 > 0.505, 0.02, -0.02)))
    assert abs(found.energy) < 2e-4
    # But for the one ring that holds both.
    assert found.mean == pytest.approx(0.02, rel=0.1)


def test_noise_is_estimated_and_subtracted():
    silent, noisy = verdict(picture(lambda mu: 0.0 * mu)), verdict(picture(lambda mu: 0.0 * mu, noise=0.2))
    assert silent.mean == silent.worst == 0.0
    # 200^2 pi / 4 pixels of 8 seeds each.
    assert noisy.noise == pytest.approx(0.2 / np.sqrt(8 * 200**2 * np.pi / 4), rel=0.05)
    assert abs(noisy.energy) < 4.0 * noisy.noise
    raw = float(np.mean(np.abs(picture(lambda mu: 0.0 * mu, noise=0.2)["value"] - 1.0)))
    assert noisy.mean < 0.03 * raw
    assert noisy.worst < 4.0 * noisy.worst_noise


def test_noise_does_not_hide_a_deviation():
    found = verdict(picture(lambda mu: 0.02 * (mu > 0.9), noise=0.1))
    assert found.worst == pytest.approx(0.02, abs=4.0 * found.worst_noise)
    assert found.worst_mu > 0.9


def test_a_picture_of_few_pixels_has_fewer_rings():
    found = verdict(picture(lambda mu: 0.01 + 0.0 * mu, size=8))
    assert len(found.mu) < RINGS
    assert found.mean == pytest.approx(0.01)
