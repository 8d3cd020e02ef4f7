"""The numerical twin of the pictures: the same deviations as the furnace of compensated models."""

import csv
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.compensation import furnace_of
from ecfit.coordinates import Axis
from ecfit.rendering.numerical import run_numerical

# Compilation takes seconds a model: fast tests have the white conductor only.
WHITE = """\
name = "twin"
r = [0.4, 1.0]
[[rows]]
name = "none"
[[rows]]
name = "fits"
conductor = ["conductor-7"]
glossy = ["glossy-10"]
entering = ["dielectric-entering-20"]
leaving = ["sforza-pellacini-2022-dielectric-leaving"]
[[materials]]
name = "conductor"
model = "conductor"
"""
ALL = """\
[[materials]]
name = "glossy"
model = "glossy"
ior = [1.1]
[[materials]]
name = "glass"
model = "dielectric"
ior = [1.5]
"""


def integrated(folder: Path, text: str):
    path = folder / "twin.toml"
    path.write_text(text)
    return run_numerical(path, folder)


@pytest.fixture(scope="module")
def white(tmp_path_factory):
    return integrated(tmp_path_factory.mktemp("white"), WHITE)


@pytest.fixture(scope="module")
def all_models(tmp_path_factory):
    return integrated(tmp_path_factory.mktemp("all"), WHITE + ALL)


def one(found, **wanted):
    (match,) = [s for s in found.scatterings if all(getattr(s, k) == v for k, v in wanted.items())]
    return match


def test_it_is_the_furnace_of_the_compensated_conductor(white):
    compare(white, "conductor", "", "conductor", "conductor-7")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("side", "fit"),
    [("entering", "dielectric-entering-20"), ("leaving", "sforza-pellacini-2022-dielectric-leaving")],
)
def test_it_is_the_furnace_of_the_compensated_dielectric(all_models, side, fit):
    """In the transport of each fit: the published one is of radiance."""
    compare(all_models, "glass", side, "dielectric", fit)


def compare(found, material: str, side: str, model: str, fit: str) -> None:
    options = {"side": side, "ior": 1.5} if side else {}
    albedo = ecfit.shipped(fit) if fit in ecfit.shipped() else ecfit.published(fit)
    axes = {"r": Axis.given("r", [0.4, 1.0]), "mu": Axis.spaced("mu", 61, 0.1, 1.0)}
    expected = furnace_of(ecfit.model(model, **options), albedo, axes, transport=albedo.contract.transport)
    mu = axes["mu"].nodes
    for r, deviation in zip((0.4, 1.0), expected.deviation, strict=True):
        mine = one(found, material=material, side=side, r=r, row="fits")
        assert mine.worst == pytest.approx(np.abs(deviation).max(), abs=2e-6)
        assert mine.energy == pytest.approx(np.average(deviation, weights=mu * _trapezoid(mu)), abs=2e-6)


def _trapezoid(x: np.ndarray) -> np.ndarray:
    width = np.diff(x)
    return 0.5 * (np.r_[width, 0.0] + np.r_[0.0, width])


def test_without_compensation_energy_is_lost(white):
    rough = one(white, material="conductor", r=1.0, row="none")
    assert rough.energy == pytest.approx(-rough.mean)
    assert 0.5 < rough.mean < 0.7


@pytest.mark.slow
def test_under_an_uncompensated_layer_the_base_takes_too_little(all_models):
    assert one(all_models, material="glossy", r=1.0, row="none").energy < -0.01


@pytest.mark.slow
def test_a_fit_outside_its_domain_has_a_star(all_models):
    assert one(all_models, material="glossy", r=0.4, row="fits").approximations == "conductor-7 + glossy-10*"


def test_the_file_lists_what_is_returned(white):
    rows = list(csv.DictReader(white.file.read_text().splitlines()))
    assert len(rows) == len(white.scatterings) == 2 * 2
    assert float(rows[0]["mean"]) == pytest.approx(white.scatterings[0].mean, rel=1e-2)
    assert white.describe()[1].startswith("fits: mean deviation at most")


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("glossy-10", "model = glossy, fresnel = exact"),
        ("conductor-correlated-16", "masking = height-correlated"),
        ("conductor-beckmann-16", "ndf = beckmann"),
        ("schlick-b-16", "quantity = schlick-b"),
        ("average-4", "quantity = average-albedo"),
    ],
)
def test_a_fit_of_another_surface_or_quantity_is_refused(tmp_path, name, fault):
    path = tmp_path / "wrong.toml"
    path.write_text(WHITE.replace('conductor = ["conductor-7"]', f'conductor = ["{name}"]'))
    with pytest.raises(
        ecfit.EcfitError, match=f"row 'fits': '{name}' has {fault}, but conductor is an albedo"
    ):
        run_numerical(path, tmp_path)


def test_a_furnace_without_a_constant_light_has_nothing_to_integrate(tmp_path):
    path = tmp_path / "studio.toml"
    path.write_text(WHITE.replace('model = "conductor"', 'model = "conductor"\nlight = "studio"'))
    with pytest.raises(ecfit.EcfitError, match="no material is in the constant light"):
        run_numerical(path, tmp_path)
