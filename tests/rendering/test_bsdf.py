"""The materials in Mitsuba: sampling, value and density agree; the albedos are those of our own models."""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import ecfit

if find_spec("mitsuba") is None:
    pytest.skip("mitsuba is not installed (extra 'render')", allow_module_level=True)

ALPHA = 0.49


@pytest.fixture(scope="module")
def checks():
    """What `bsdf_checks.py` found, in a process of its own: LLVM and a variant's classes stay out of this."""
    from ecfit.rendering.variant import FAST, choose

    variant = choose()
    if variant.name != FAST:
        pytest.skip("no LLVM for Mitsuba: a million directions take minutes in scalar mode")
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("bsdf_checks.py")), variant.name],
        env={**os.environ, **variant.environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return [json.loads(line) for line in done.stdout.splitlines()]


def line(mu: float) -> float:
    """The stand-in for E that all compensated materials there have."""
    return float(np.interp(mu, [0.0, 0.25, 1.0], [0.5, 0.7, 0.9]))


def test_samples_follow_the_density(checks):
    assert len(checks) == 14
    for found in checks:
        where = (found["model"], found["z"])
        assert found["pdf"] == pytest.approx(found["valid"], abs=4e-3), where
        # Mean bins, standard deviation sqrt(2 bins).
        assert found["chi2"] < found["bins"] + 5.0 * (2.0 * found["bins"]) ** 0.5, where


def test_a_sample_weighs_value_over_density(checks):
    for found in checks:
        assert found["ratio"] < 1e-3, (found["model"], found["z"])
        assert found["sampled"] == pytest.approx(found["eval"], abs=5.0 * found["scatter"] + 1e-3)


def test_the_integral_is_the_albedo_over_the_stand_in(checks, reference_albedo):
    for found in checks:
        mu, model = abs(found["z"]), found["model"]
        if model == "dielectric":
            continue
        expected = reference_albedo("ggx", "separable", mu, ALPHA) / line(mu)
        if model == "glossy":
            layer = reference_albedo("ggx", "separable", mu, ALPHA, fresnel)
            expected = (
                layer / line(mu) + 1.0 - line(mu) if found["compensated"] else layer + 1.0 - fresnel(mu)
            )
        assert found["eval"] == pytest.approx(expected, abs=1e-3), (model, found["z"])


@pytest.mark.slow
def test_the_integral_of_a_dielectric_is_that_of_our_model_over_the_stand_in(checks):
    """f is the radiance BSDF on both sides."""
    for found in checks:
        if found["model"] == "dielectric":
            model = ecfit.model("dielectric", side="entering" if found["z"] > 0.0 else "leaving")
            at = {"mu": abs(found["z"]), "alpha": ALPHA, "ior": 1.5}
            expected = float(ecfit.directional_albedo(model, transport="radiance", **at)) / line(at["mu"])
            # Below mu = 0.35 most of the light leaves near total reflection, where the rule there has a kink.
            assert found["eval"] == pytest.approx(expected, abs=3e-3 if found["z"] == -0.35 else 1e-3), found
            assert found["sampled"] == pytest.approx(expected, abs=5.0 * found["scatter"])


def fresnel(mu, ior: float = 1.5):
    """Textbook Fresnel equations, from outside."""
    inner = (1.0 - (1.0 - mu * mu) / ior**2) ** 0.5
    s, p = (mu - ior * inner) / (mu + ior * inner), (ior * mu - inner) / (ior * mu + inner)
    return 0.5 * (s * s + p * p)
