"""Running a furnace: spheres that are not on disk are rendered; numbers, pictures and page are written."""

import csv
import io
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ecfit.config.furnace import FurnaceConfig, read_furnace
from ecfit.errors import EcfitError
from ecfit.files import make_folder, write_text
from ecfit.progress import Progress
from ecfit.rendering.page import page
from ecfit.rendering.pictures import by_size, colour_picture, furnace_picture, percent
from ecfit.rendering.plan import Albedos, spheres
from ecfit.rendering.sphere import Sphere
from ecfit.rendering.variant import Variant, choose
from ecfit.rendering.verdict import Verdict, verdict

COLUMNS = (
    "material", "ior", "r", "row", "approximation", "mean", "worst", "worst_mu", "energy", "noise",
    "worst_noise", "rest", "pixels", "samples", "seeds", "candidates", "depth", "variant", "seconds",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Rendered:
    """A sphere's picture.

    Attributes:
        sphere: what was rendered.
        picture: height x width x 1 (furnace: light) or 4 (colour and coverage).
        verdict: the numbers; None under another light than the furnace's.
        variant: of Mitsuba.
        seconds: that it took.
    """

    sphere: Sphere
    picture: np.ndarray
    verdict: Verdict | None
    variant: str
    seconds: float


@dataclass(frozen=True, eq=False)
class FurnaceRun:
    """What a furnace has written.

    Attributes:
        folder: `results/<name>`.
        rendered: all spheres, in the order of the config.
        computed: how many of them were rendered now; the others were on disk.
    """

    folder: Path
    rendered: list[Rendered]
    computed: int

    @property
    def page(self) -> Path:
        """The page with all pictures."""
        return self.folder / "furnace.md"

    def describe(self) -> list[str]:
        """Lines for people to read: the spheres of each row that deviate most."""
        out = []
        for row in dict.fromkeys(one.sphere.row for one in self.rendered):
            judged = [one for one in self.rendered if one.sphere.row == row and one.verdict is not None]
            if judged:
                far = max(judged, key=lambda one: by_size(_mean(one)))
                out.append(
                    f"{row}: mean deviation at most {percent(_mean(far))}, "
                    f"of {far.sphere.picture} at r = {far.sphere.r:g}"
                )
        return out


def _mean(one: Rendered) -> float:
    return 0.0 if one.verdict is None else one.verdict.mean


def run_furnace(
    path: str | Path,
    results: str | Path = "results",
    *,
    progress: Progress | None = None,
    told: Callable[[str], object] = lambda text: None,
) -> FurnaceRun:
    """Render the furnace of a config file and write `furnace.csv`, `furnace.md` and one PNG a picture.

    Args:
        path: the TOML file (`ecfit.config.furnace`).
        results: folder of all results; small tables are shared in `results/tables`.
        progress: told what is tabulated and rendered.
        told: told in words what else there is to know.

    What is finished is kept: running again resumes. Raises `EcfitError` for faults in the file, unknown
    names, and where Mitsuba is not installed.
    """
    config = read_furnace(path)
    variant = choose()
    if variant.remark:
        told(variant.remark)
    folder = make_folder(Path(results) / config.name)
    tell = progress or Progress()
    planned = spheres(config, Albedos(config, Path(results), tell))
    missing = [s for s in planned if not _file(folder, s, variant).exists()]
    if missing:
        with tell.stage(f"spheres ({variant.name})", len(missing)) as advance:
            _render(missing, folder, variant, advance)
    rendered = [_read(folder, sphere, variant) for sphere in planned]
    _write(config, folder, rendered)
    return FurnaceRun(folder, rendered, len(missing))


def _file(folder: Path, sphere: Sphere, variant: Variant) -> Path:
    return folder / "renders" / f"{sphere.key(variant.name)}.npz"


def _render(
    missing: Sequence[Sphere], folder: Path, variant: Variant, advance: Callable[[int], object]
) -> None:
    """Have all spheres rendered by another process."""
    renders = make_folder(folder / "renders")
    # A file, as a pipe that nobody reads until the end would stop a process that has much to say.
    with tempfile.TemporaryDirectory() as temporary, tempfile.TemporaryFile("w+") as log:
        jobs = Path(temporary) / "spheres.json"
        jobs.write_text(json.dumps([sphere.to_dict() for sphere in missing]), encoding="utf-8")
        command = [sys.executable, "-m", "ecfit.rendering.worker", variant.name, str(jobs), str(renders)]
        with subprocess.Popen(
            command,
            env={**os.environ, **variant.environment},
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        ) as process:
            assert process.stdout is not None
            for _ in process.stdout:
                advance(1)
        log.seek(0)
        errors = log.read()
    if process.returncode:
        why = errors.strip().splitlines()[-1:] or [f"exit code {process.returncode}"]
        raise EcfitError(f"the renderer stopped: {why[0]}; finished spheres are kept")


def _read(folder: Path, sphere: Sphere, variant: Variant) -> Rendered:
    with np.load(_file(folder, sphere, variant), allow_pickle=False) as file:
        arrays = dict(file)
    found = verdict(arrays) if sphere.light == "constant" else None
    return Rendered(sphere, arrays["picture"], found, variant.name, float(arrays["seconds"]))


def _write(config: FurnaceConfig, folder: Path, rendered: Sequence[Rendered]) -> None:
    pictures: dict[str, list[Rendered]] = {}
    for one in rendered:
        pictures.setdefault(one.sphere.picture, []).append(one)
    rows = [row.name for row in config.rows]
    for stem, members in pictures.items():
        draw = furnace_picture if members[0].verdict is not None else colour_picture
        (folder / f"{stem}.png").write_bytes(draw(members, rows, config.r))
    if any(one.verdict is not None for one in rendered):
        write_text(folder / "furnace.csv", summary(rendered))
    write_text(folder / "furnace.md", page(config, pictures))


def summary(rendered: Sequence[Rendered]) -> str:
    """The furnace's spheres as CSV, one row each."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in rendered:
        sphere, found = one.sphere, one.verdict
        if found is None:
            continue
        ior = "" if sphere.ior is None else f"{sphere.ior:g}"
        numbers = (
            found.mean,
            found.worst,
            found.worst_mu,
            found.energy,
            found.noise,
            found.worst_noise,
            found.rest,
        )
        writer.writerow(
            [
                sphere.material, ior, f"{sphere.r:g}", sphere.row, sphere.approximations,
                *(f"{n:.3g}" for n in numbers),
                sphere.pixels, sphere.samples, sphere.seeds, sphere.candidates, sphere.depth,
                one.variant, f"{one.seconds:.1f}",
            ]
        )  # fmt: skip
    return out.getvalue()
