"""How far runs of one study are apart: run twice, with more threads and workers, and on lesser processors.

    python benchmarks/reproducible.py                            # configs/quick.toml, about five minutes
    python benchmarks/reproducible.py configs/paper-small.toml   # any other study
    python benchmarks/reproducible.py configs/best.toml --tables conductor schlick-b
    python benchmarks/reproducible.py --write                    # puts the rows into docs/trust.md

Every run is a fresh process with a fresh results folder and without the compilation cache. A lesser processor
is this one, held to an instruction set: XLA by --xla_cpu_max_isa, OpenBLAS by OPENBLAS_CORETYPE and NumPy by
NPY_DISABLE_CPU_FEATURES, all of which change the order of sums and whether products are fused into them. That
needs an x86 processor with AVX-512, or the first rows are the same code twice. Tables are integrated by each
run, so their differences are in those of the fits.

The exit code is 1 where runs that should be the same differ in a byte, or where a fit moves by more than
`ecfit.study.apart` promises.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import common
import numpy as np

from ecfit._cache import SWITCH
from ecfit.config import read_config, to_toml
from ecfit.study.apart import SAME_ENTRY, SAME_FUNCTION, fits_apart, tables_apart
from ecfit.workers import ONE_THREAD

ROOT = Path(__file__).resolve().parent.parent


class Setting(NamedTuple):
    """How a study is run: environment and workers. The bytes of `exact` ones must be those of the first."""

    name: str
    environment: Mapping[str, str]
    workers: int
    exact: bool


def _processor(isa: str, core: str, features: str) -> dict[str, str]:
    return {
        "XLA_FLAGS": f"--xla_cpu_max_isa={isa}",
        "OPENBLAS_CORETYPE": core,
        "NPY_DISABLE_CPU_FEATURES": features,
    }


# Features are those that NumPy's x86 wheels dispatch on, without the baseline, which cannot be disabled.
_AVX512 = "X86_V4 AVX512_ICL AVX512_SPR"
SETTINGS = (
    Setting("one thread, one worker", {}, 1, True),
    Setting("the same again", {}, 1, True),
    Setting("two threads", {name: "2" for name in ONE_THREAD}, 1, True),
    Setting("two workers", {}, 2, True),
    Setting("AVX2", _processor("AVX2", "Haswell", _AVX512), 1, False),
    Setting("AVX, no fused products", _processor("AVX", "Sandybridge", f"X86_V3 {_AVX512}"), 1, False),
    Setting("SSE4.2", _processor("SSE4_2", "Nehalem", f"X86_V3 {_AVX512}"), 1, False),
)


def run(config: Path, results: Path, setting: Setting) -> None:
    """`ecfit run` in a process of its own."""
    kept = {k: v for k, v in os.environ.items() if k not in ("XLA_FLAGS", "JAX_COMPILATION_CACHE_DIR")}
    subprocess.run(
        [
            sys.executable, "-c", "from ecfit.cli import main; main()",
            "run", str(config), "--results", str(results), "--workers", str(setting.workers),
        ],
        check=True,
        stdout=subprocess.DEVNULL,
        env={**kept, **ONE_THREAD, SWITCH: "off", **setting.environment},
    )  # fmt: skip


def files(results: Path) -> dict[str, bytes]:
    """All that a run wrote, but how long it took."""
    return {
        str(p.relative_to(results)): p.read_bytes()
        for p in sorted(results.rglob("*"))
        if p.is_file() and p.name != "timings.csv"
    }


def only(config: Path, tables: Sequence[str], folder: Path) -> Path:
    """A study file with some of a config's tables, and the fits of these alone."""
    data = read_config(config).model_dump(exclude_none=True, by_alias=True)
    data["tables"] = [t for t in data["tables"] if t["name"] in tables]
    for kind in ("fits", "compare"):
        for entry in data[kind]:
            entry["tables"] = [name for name in entry["tables"] if name in tables]
        data[kind] = [entry for entry in data[kind] if entry["tables"]]
    data["report"] = {**data["report"], "figures": []}
    path = folder / config.name
    path.write_text(to_toml({key: value for key, value in data.items() if value != []}), encoding="utf-8")
    return path


def measured(config: Path, folder: Path) -> tuple[list[list[str]], bool]:
    """A row a setting, and whether all promises are kept."""
    first, rows, kept = folder / "0", [], True
    for i, setting in enumerate(SETTINGS):
        results = folder / str(i)
        run(config, results, setting)
        if i == 0:
            continue
        old, new = files(first), files(results)
        differ = [name for name in sorted(old | new) if old.get(name) != new.get(name)]
        tables, fits = tables_apart(config, first, results), fits_apart(config, first, results)
        kept &= not (setting.exact and differ)
        kept &= max(tables.values()) <= SAME_ENTRY and all(f.same for f in fits)
        relative = np.array([f.function / f.max_error for f in fits])
        worst = fits[int(np.argmax(relative))]
        rows.append([
            setting.name,
            f"{len(old) - len(differ)} of {len(old)}",
            f"{max(tables.values()):.1e}",
            f"{np.median([f.coefficients for f in fits]):.1e}",
            f"{max(f.coefficients for f in fits):.1e}",
            f"{max(f.function for f in fits):.1e}",
            f"{np.max(relative):.1e}",
            worst.label,
        ])  # fmt: skip
        print(f"{config.name}: {' | '.join(rows[-1])}", flush=True)
        for f in sorted(fits, key=lambda f: -f.function / f.max_error)[:5]:
            print("   ", f)
        print("   ", differ[:6])
    return rows, kept


HEADER = (
    "against one thread, one worker", "files the same", "entry / tolerance", "coefficient, median", "worst",
    "function", "/ largest error", "fit",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("configs", nargs="*", type=Path, default=[ROOT / "configs" / "quick.toml"])
    parser.add_argument("--tables", nargs="+", help="only these tables of the config, and their fits")
    given = parser.parse_args()
    fine = True
    for config in given.configs:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            rows, kept = measured(only(config, given.tables, folder) if given.tables else config, folder)
        common.show(config.name, HEADER, rows)
        fine &= kept
    raise SystemExit(0 if fine else 1)


if __name__ == "__main__":
    main()
