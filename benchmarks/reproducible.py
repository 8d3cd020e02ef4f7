"""How far runs of one study are apart: run twice, with more threads and workers, and on lesser processors.

    python benchmarks/reproducible.py                      # configs/quick.toml: seven runs in five minutes
    python benchmarks/reproducible.py --quick CONFIG ...   # two runs: as it is, and held to SSE4.2
    python benchmarks/reproducible.py --quick configs/best.toml --tables conductor-correlated average

Prints Markdown. Every run is a fresh process with a fresh results folder and without the compilation cache. A
lesser processor is this one, held to an instruction set: XLA by --xla_cpu_max_isa, OpenBLAS by
OPENBLAS_CORETYPE and NumPy by NPY_DISABLE_CPU_FEATURES, all of which change the order of sums and whether
products are fused into them. That needs an x86 processor with AVX-512; on others some rows are the same code
twice. Each run integrates its own tables, so that their differences are in those of the fits.

The exit code is 1 where runs that should be the same differ in a byte, or where a table or fit moves by more
than `ecfit.study.apart` promises.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import common  # noqa: F401  (before NumPy: one thread for OpenBLAS)

from ecfit._cache import SWITCH
from ecfit.config import read_config, to_toml
from ecfit.study.apart import SAME_ENTRY, fits_apart, tables_apart
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


def measured(config: Path, settings: Sequence[Setting], folder: Path) -> bool:
    """Print a row a setting; whether all promises are kept."""
    first, kept = folder / "0", True
    run(config, first, settings[0])
    old = files(first)
    for i, setting in enumerate(settings[1:], 1):
        results = folder / str(i)
        run(config, results, setting)
        new = files(results)
        differ = [name for name in sorted(old | new) if old.get(name) != new.get(name)]
        tables, fits = tables_apart(config, first, results), fits_apart(config, first, results)
        worst = max(fits, key=lambda f: f.share)
        cells = (
            f"`{config.name}`", setting.name, f"{len(old) - len(differ)} of {len(old)}",
            f"{max(tables.values()):.0e}", f"{max(f.coefficients for f in fits):.0e}",
            f"{max(f.function for f in fits):.0e}", f"{worst.share:.0e} ({worst.label})",
        )  # fmt: skip
        print(f"| {' | '.join(cells)} |", flush=True)
        if setting.exact:
            kept &= not differ
            print(*(f"  differs: {name}" for name in differ), sep="\n", file=sys.stderr)
        kept &= max(tables.values()) <= SAME_ENTRY and all(f.same for f in fits)
    return kept


HEADER = """
| study | against one thread and one worker | files the same | entry / tolerance | coefficient | function | / largest error |
|---|---|---:|---:|---:|---:|---:|"""  # noqa: E501


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("configs", nargs="*", type=Path, default=[ROOT / "configs" / "quick.toml"])
    parser.add_argument("--tables", nargs="+", help="only these tables of the configs, and their fits")
    parser.add_argument("--quick", action="store_true", help="the first setting and the last only")
    given = parser.parse_args()
    settings = [SETTINGS[0], SETTINGS[-1]] if given.quick else SETTINGS
    print(HEADER, flush=True)
    kept = True
    for config in given.configs:
        with tempfile.TemporaryDirectory() as name:
            chosen = only(config, given.tables, Path(name)) if given.tables else config
            kept &= measured(chosen, settings, Path(name))
    raise SystemExit(0 if kept else 1)


if __name__ == "__main__":
    main()
