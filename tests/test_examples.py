"""The numbered examples: each runs, and what it claims holds. Small here; the slow ones as users run them."""

import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import ecfit
from ecfit.workers import ONE_THREAD

EXAMPLES = Path(__file__).parents[1] / "examples"
PAGES = sorted(path.stem for path in EXAMPLES.glob("[0-9]*.py"))


@pytest.fixture(scope="module", autouse=True)
def here() -> Iterator[None]:
    """Plots without a screen, studies in this process, `ward` beside its page."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(EXAMPLES))
        patch.setenv("MPLBACKEND", "agg")
        for name, value in ONE_THREAD.items():
            patch.setenv(name, value)
        yield


@pytest.fixture
def page() -> Iterator[Callable[[str], ModuleType]]:
    """`page(name)`: an example, imported and not run; its figures are closed afterwards."""

    def load(name: str) -> ModuleType:
        spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        # Equinox and `NamedTuple` look their module up by name.
        sys.modules[spec.name] = module
        try:
            spec.loader.exec_module(module)
        finally:
            del sys.modules[spec.name]
        return module

    yield load
    from matplotlib import pyplot

    pyplot.close("all")


def test_the_list_of_examples_is_complete_and_has_nothing_else():
    text = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    linked = set(re.findall(r"\]\(([\w.]+)\)", text))
    assert linked == {path.name for path in EXAMPLES.iterdir() if path.suffix in (".py", ".toml")}


@pytest.mark.parametrize("name", PAGES)
def test_a_page_says_how_it_is_run_and_what_it_prints(name, page):
    text = page(name).__doc__
    assert f"python examples/{name}.py\n" in text
    assert "Printed: " in text
    assert text.splitlines()[0].endswith((".", "?"))


def test_01_measures_the_fit_where_it_was_not_fitted(page, capsys):
    found = page("01_fit_a_model").main(nodes=8, degree=1)
    assert found.fit.ok
    # Other nodes, another error; of the same size, since the form is smooth and has few coefficients.
    assert found.unseen.rmse != found.fit.rmse
    assert 0.3 < found.unseen.rmse / found.fit.rmse < 3.0
    printed = capsys.readouterr().out
    assert f"RMSE {found.unseen.rmse:.4e}" in printed
    assert "float rational_1(float mu, float r)" in printed
    said = re.search(r"the fit says ([\d.]+), the integral ([\d.]+)", printed)
    assert said is not None
    fitted, integral = map(float, said.groups())
    assert abs(fitted - integral) <= found.unseen.max_error


@pytest.mark.slow
def test_02_checks_and_fits_a_model_that_ecfit_does_not_know(page, capsys, tmp_path):
    found = page("02_own_bsdf").main(nodes=8, degrees=2, samples=50, output=tmp_path)
    assert found.check
    assert found.table.contract.model == "ward"
    assert [fit.approximation.count for fit in found.fits] == [3, 6, 5, 11]
    assert found.fits[3].rmse < found.fits[1].rmse
    assert "ward: passed" in capsys.readouterr().out
    assert (tmp_path / "02-ward.png").exists()


def test_03_prints_what_the_summary_says(page, capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("ecfit.report.write_report", lambda study: None)  # it takes longer than all else here
    config = tmp_path / "small.toml"
    config.write_text(
        """name = "small"
tables = [{ name = "one", model = "conductor", axes = { r = 8, mu = 8 } }]
fits = [{ tables = ["one"], form = "polynomial", degree = [1, 2] }]
compare = [{ tables = ["one"], published = ["kulla-conty-2017"] }]
""",
        encoding="utf-8",
    )
    found = page("03_sweep").main(config=config, output=tmp_path)
    assert [row["form"] for row in found.rows] == ["polynomial", "polynomial", "kulla-conty-2017"]
    for row, fit in zip(found.rows, found.study.fits["one"], strict=False):
        assert float(row["rmse"]) == pytest.approx(fit.rmse, rel=1e-6)
        assert int(row["coefficients"]) == fit.coefficients.size
    printed = capsys.readouterr().out
    assert f"{found.study.fits['one'][1].rmse:9.2e}" in printed
    assert "Best fit of the study: polynomial 2" in printed
    assert (tmp_path / "03-sweep.png").exists()


def test_the_study_of_03_is_a_study():
    from ecfit.config import read_config
    from ecfit.study import make_plan

    plan = make_plan(read_config(EXAMPLES / "sweep.toml"), EXAMPLES)
    assert (len(plan.requests), len(plan.fits)) == (2, 16)


def test_04_errs_half_as_much_as_a_plane_of_as_many_numbers(page, capsys, tmp_path):
    found = page("04_own_form").main(nodes=8, output=tmp_path)
    assert found.ours.ok
    assert found.ours.coefficients.size == found.plane.coefficients.size == 3
    assert found.ours.rmse < 0.6 * found.plane.rmse
    # What its text says of the coefficients: losses that grow from grazing to above, and no pole.
    c0, c1, c2 = found.ours.coefficients
    assert 0.0 < c0 < c1
    assert c2 > 0.0
    np.testing.assert_array_equal(found.again.coefficients, found.ours.coefficients)
    assert "the fitted module: Blend(" in capsys.readouterr().out
    assert (tmp_path / "04-blend.png").exists()


def test_05a_recovers_what_the_curve_was_made_from(page, tmp_path, capsys):
    module = page("05a_recover_roughness")
    found = module.main(repeats=1, output=tmp_path)
    (other,) = found.repeated
    for estimate in (found.estimate, other):
        assert np.all(np.abs(estimate.off) < 3.0)
        # Stated uncertainties that are small enough to mean something, and no accident of the start.
        assert np.all(estimate.sigmas < 0.02 * module.TRUTH)
        assert np.all(estimate.sigmas > 0.0)
        assert np.all(np.abs(estimate.values - module.START) > 10.0 * estimate.sigmas)
    assert np.all(other.values != found.estimate.values)
    assert "made here" in capsys.readouterr().out
    assert (tmp_path / "05a-recovered.png").exists()


@pytest.mark.slow
def test_05a_states_uncertainties_that_hold(page):
    """About 68 of 100 repetitions lie within one sigma: fewer than 54 or more than 82 once in 500 such tests.

    Sigmas that were wrong by a factor of 1.5 would give 50 or 87.
    """
    found = page("05a_recover_roughness").main(repeats=100, seed=5)
    off = np.abs([estimate.off for estimate in found.repeated])
    within = (off < 1.0).mean(axis=0)
    assert np.all((within > 0.54) & (within < 0.82))


@pytest.mark.slow
@pytest.mark.parametrize(("degree", "learned_wins"), [(1, False), (2, True), (3, True)])
def test_05b_compares_at_equal_numbers_and_says_who_wins(page, degree, learned_wins, tmp_path):
    module = page("05b_learn_a_map")
    found = module.main(degree=degree, output=tmp_path)
    assert found.learned.ok
    assert found.fixed.ok
    assert found.learned.coefficients.size == found.fixed.coefficients.size
    assert found.learned.rmse < found.plain.rmse  # it begins there
    assert (found.learned.rmse < found.fixed.rmse) is learned_wins
    assert set(found.exponents) == {"r", "mu"}
    assert (tmp_path / "05b-map.png").exists()


def test_06_compares_with_the_compilers_that_there_are(page, capsys, tmp_path):
    module = page("06_check_in_a_shader")
    found = module.main(tools=("cc",), points=512, output=tmp_path)
    (report,) = found.reports
    assert report.passes
    printed = capsys.readouterr().out
    assert "float conductor_10(float mu, float alpha)" in printed
    if report.outcome is None:
        pytest.skip(report.reason)
    assert "as in Python on 1 of 1 tools" in printed
    assert (tmp_path / "conductor-10.c").read_text() == ecfit.shipped("conductor-10").to_code("c")


def test_06_says_what_to_install_where_nothing_is_there(page, capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", "")
    found = page("06_check_in_a_shader").main(tools=("cc", "glslang"))
    assert all(report.passes and report.outcome is None for report in found.reports)
    printed = capsys.readouterr().out
    assert "not here: no cc: a C compiler" in printed
    assert "nothing to compare with: none of cc, glslang is here" in printed


def test_07_finds_the_mistake_that_the_page_made(page, capsys, tmp_path):
    found = page("07_audit_a_table").main(nodes=8, output=tmp_path)
    assert not found.claimed
    assert found.claimed.faults == ["alpha given as r"]
    assert found.mended
    printed = capsys.readouterr().out
    assert "theirs.csv: NOT AS CLAIMED" in printed
    assert "r read as alpha: as claimed" in printed
    assert (tmp_path / "theirs.csv").read_text().splitlines()[1] == "r,mu,value"


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_a_page_runs_as_it_says_and_is_quiet(name, tmp_path):
    """As a user runs it: figures where they are asked for, nothing on stderr, nothing anywhere else."""
    figures, elsewhere = tmp_path / "figures", tmp_path / "elsewhere"
    elsewhere.mkdir()
    environment = {**os.environ, **ONE_THREAD, "MPLBACKEND": "agg", "TMPDIR": str(tmp_path)}
    before = os.times().children_user
    done = subprocess.run(
        [sys.executable, EXAMPLES / f"{name}.py", "--output", figures],
        cwd=elsewhere, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    spent = os.times().children_user - before
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) > 4
    assert list(figures.iterdir())
    assert list(elsewhere.iterdir()) == []
    assert spent < 90.0  # seconds of CPU; the list of examples has what was measured
