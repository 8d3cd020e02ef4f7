"""The wheel and the sdist: what is in them, and that an installed ecfit runs where there is no repository."""

import os
import shutil
import subprocess
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

import ecfit

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
# What uv says where there is no network; anything else that fails is a fault of ours.
NO_NETWORK = ("dns error", "error sending request", "failed to fetch", "connection", "timed out")
# A study of seconds that needs what comes with the package: a published and a shipped fit, and templates.
STUDY = """
name = "small"
[[tables]]
name = "metal"
model = "conductor"
options = { masking = "separable" }
axes = { r = 12, mu = 12 }
tolerance = 1e-4
[[fits]]
tables = ["metal"]
form = "polynomial"
degree = [1, 2]
[[compare]]
tables = ["metal"]
published = ["sforza-pellacini-2022-conductor"]
shipped = ["conductor-10"]
[report]
figures = ["svg"]
"""

Installed = Callable[..., subprocess.CompletedProcess[str]]


def uv(*words: object) -> str:
    """What uv prints; the test skips where there is no uv or no network."""
    try:
        from uv import find_uv_bin

        program: str | None = find_uv_bin()
    except (ImportError, FileNotFoundError):
        program = shutil.which("uv")
    if program is None:
        pytest.skip("no uv: pip install uv")
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, timeout=600)
    if done.returncode and any(sign in done.stderr.lower() for sign in NO_NETWORK):
        pytest.skip(f"no package index: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist, and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    uv("build", "--quiet", "--out-dir", folder, ROOT)
    return folder


@pytest.fixture(scope="module")
def installed(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Runs `ecfit words` of an environment that holds the wheel alone, in a folder far from here."""
    folder = tmp_path_factory.mktemp("elsewhere")
    environment = folder / "environment"
    uv("venv", "--quiet", environment)
    scripts = environment / ("Scripts" if os.name == "nt" else "bin")
    (wheel,) = built.glob("*.whl")
    uv("pip", "install", "--quiet", "--python", scripts / "python", "-c", ROOT / "constraints.txt", wheel)
    kept = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))
    }

    def call(*words: str, program: str = "ecfit") -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [scripts / program, *words], cwd=folder, env=kept, capture_output=True, text=True, timeout=600
        )

    where = call("-c", "import ecfit; print(ecfit.__file__)", program="python").stdout.strip()
    assert Path(where).is_relative_to(environment)
    return call


def test_the_wheel_holds_the_package_and_its_data_and_nothing_else(built: Path):
    (wheel,) = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    # What a checkout has of them, but caches of Python.
    files = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "ecfit").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    configs = {f"ecfit/data/configs/{path.name}" for path in (ROOT / "configs").glob("*.toml")}
    assert configs
    assert {n for n in names if ".dist-info/" not in n} == files | configs
    assert wheel.stat().st_size < 1e6


def test_the_sdist_holds_sources_and_results_in_numbers_but_no_pictures(built: Path):
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as file:
        names = {name.partition("/")[2] for name in file.getnames()}
    for needed in ("pyproject.toml", "LICENSE", "README.md", "constraints.txt", "Makefile"):
        assert needed in names
    for needed in ("configs/quick.toml", "tests/test_wheel.py", "results/quick/summary.csv"):
        assert needed in names
    unwanted = (".pyc", ".npz", ".png", ".svg", ".html", ".log")
    assert not [name for name in names if name.endswith(unwanted) and name.startswith("results/")]
    assert not [
        name for name in names if "__pycache__" in name or name.startswith((".venv", "results/tables"))
    ]
    assert not [name for name in names if name.startswith("docs/figures/")]
    assert sdist.stat().st_size < 2e6


def test_it_says_what_it_is(installed: Installed):
    assert installed("--version").stdout.strip() == ecfit.__version__
    assert "Usage: ecfit COMMAND" in installed("--help").stdout
    assert installed("-m", "ecfit", "--version", program="python").stdout.strip() == ecfit.__version__
    listed = installed("list").stdout
    for word in ("conductor-10", "sforza-pellacini-2022-conductor", "cycles", "eon"):
        assert word in listed


def test_it_writes_every_study_that_comes_with_it(installed: Installed):
    for path in (ROOT / "configs").glob("*.toml"):
        done = installed("init", f"like-{path.name}", "--like", path.stem)
        assert done.returncode == 0, done.stderr
    assert installed("init").returncode == 0


def test_a_study_runs_and_its_results_are_read_again(installed: Installed):
    folder = Path(installed("-c", "import os; print(os.getcwd())", program="python").stdout.strip())
    (folder / "small.toml").write_text(STUDY)
    done = installed("run", "small.toml")
    assert done.returncode == 0, done.stderr
    assert "</html>" in (folder / "results/small/report.html").read_text()
    for words in (
        ("compare", "results/small", "results/small"),
        ("verify", "results/small", "--entries", "32", "--refits", "1"),
        ("check-bsdf", "lambertian", "--samples", "20"),
    ):
        done = installed(*words)
        assert done.returncode == 0, (words, done.stderr)


def test_fits_that_come_with_it_become_code(installed: Installed):
    for words, text in (
        (("export", "conductor-10", "--lang", "glsl"), "float conductor_10("),
        (("export", "sforza-pellacini-2022-conductor", "--lang", "c"), "float sforza_pellacini"),
        (("export", "conductor-16", "--lang", "materialx", "--output", "mx"), "conductor_16.glsl"),
        (("export-table", "kulla-conty-2017", "--layout", "yocto", "--axis", "r=8", "--axis", "mu=8",
          "--output", "t.h"), "8 x 8 numbers"),
    ):  # fmt: skip
        done = installed(*words)
        assert done.returncode == 0, done.stderr
        assert text in done.stdout
