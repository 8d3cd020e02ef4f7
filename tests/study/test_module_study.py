"""A study whose plugin registers a form."""

from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.config import read_config
from ecfit.errors import EcfitError
from ecfit.study.plan import make_plan

PLUGIN = """
import equinox as eqx
import jax
import jax.numpy as jnp
import ecfit


@ecfit.register_form("decay")
class Decay(eqx.Module):
    "1 minus a decay."
    a: jax.Array
    power: int = eqx.field(static=True)

    def __init__(self, power=1):
        self.a, self.power = jnp.ones(2), power

    def __call__(self, mu, alpha):
        return 1.0 - self.a[0] * alpha**self.power * jnp.exp(-self.a[1] * mu)
"""

CONFIG = """
name = "modules"
plugins = ["decay_form.py"]
[[tables]]
name = "e"
file = "e.csv"
axes = { r = 8, mu = 8 }
[[fits]]
tables = ["e"]
form = "module"
module = "decay"
settings = { power = 2 }
weights = { mu = 1.0 }
[report]
figures = ["svg"]
"""


def written(folder: Path, text: str = CONFIG, plugin: str = PLUGIN) -> Path:
    (folder / "decay_form.py").write_text(plugin)
    r, mu = np.meshgrid(*[np.linspace(0.0, 1.0, 8)] * 2, indexing="ij")
    np.savetxt(folder / "e.csv", 1.0 - 0.6 * r**4 * np.exp(-0.5 * mu), delimiter=",")
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


@pytest.mark.usefixtures("no_report")
def test_a_study_fits_a_plugins_module_and_finds_it_again(tmp_path: Path):
    config = written(tmp_path)
    study = ecfit.run(config, tmp_path / "results")
    (fit,) = study.fits["e"]
    assert (fit.approximation.form, fit.approximation.degree, fit.status) == ("decay", "2", "converged")
    assert (tmp_path / "results" / "modules" / "fits" / "e-decay-2.json").is_file()
    assert ecfit.run(config, tmp_path / "results").seconds == {}


def test_a_change_of_the_plugins_code_is_another_fit(tmp_path: Path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    plans = [
        make_plan(read_config(written(tmp_path / n, plugin=p)), tmp_path / n)
        for n, p in (("a", PLUGIN), ("b", PLUGIN + "\n# other\n"))
    ]
    assert plans[0].fits[0].key != plans[1].fits[0].key


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('module = "decay"', 'module = "decoy"', "no module form 'decoy'.*did you mean 'decay'"),
        ('module = "decay"\n', "", "the form 'module' needs module"),
        ("power = 2", "pover = 2", "cannot be made of the settings"),
        ("weights = { mu = 1.0 }", "weights = { nu = 1.0 }", "no coordinate 'nu'"),
        ("weights = { mu = 1.0 }", 'norm = "l1"', "norm does not belong to the form 'module'"),
        ("weights = { mu = 1.0 }", "monotone = { mu = 2 }", "expected one of 1, -1"),
        ('form = "module"\nmodule = "decay"', 'form = "rational"\ndegree = 1', "settings does not belong"),
        ("settings =", "setings =", "did you mean 'settings'"),
    ],
)
def test_faults_are_told_before_anything_is_computed(tmp_path: Path, old: str, new: str, message: str):
    config = written(tmp_path, CONFIG.replace(old, new))
    with pytest.raises(EcfitError, match=message):
        make_plan(read_config(config), tmp_path)


@pytest.mark.usefixtures("no_report")
def test_the_resolved_config_of_a_module_can_be_run_again(tmp_path: Path):
    study = ecfit.run(written(tmp_path), tmp_path / "results")
    assert ecfit.run(study.folder / "config.toml", tmp_path / "results").seconds == {}
