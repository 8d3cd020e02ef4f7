"""Studies: begun, run, reported, compared, verified."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ecfit.cli.terminal import bars, say


def init(output: Path = Path("study.toml"), *, like: str = "starter") -> None:
    """Write a study file with comments to start from; a file that exists is never overwritten.

    Parameters
    ----------
    output
        The TOML file to write; the study is named after it.
    like
        starter, or a study that comes with ecfit: quick, conductor, paper, search, ...
    """
    from ecfit.starter import command_for, write_config

    written = write_config(output, like)
    print(f"written: {written}; run it with: ecfit {command_for(written)} {written}")


def run(
    config: Path,
    *,
    results: Annotated[Path, Parameter(help="Folder for all studies.")] = Path("results"),
    workers: int | None = None,
    scheduler: str | None = None,
) -> None:
    """Run a study: tables, fits and report. Finished parts are kept; running again resumes.

    Parameters
    ----------
    config
        The study's TOML file.
    workers
        Processes that fit at most, a table each; by default the processors that may be used.
    scheduler
        The address of a Dask scheduler, tcp://host:8786: its workers search and fit instead.
    """
    from ecfit.config import read_config
    from ecfit.workers import check_workers

    check_workers(workers)
    read_config(config)  # a fault in the file is told before JAX takes its second to load
    from ecfit import study

    done = study.run(config, results, workers=workers, scheduler=scheduler, progress=bars())
    for warning in done.warnings():
        say(f"WARNING: {warning}")
    for name, fits in done.fits.items():
        for found in fits:
            if found.least_max_error is not None:
                print(f"table {name}: {found.approximation.name}: {found.least_line()}")
    computed = f"{len(done.seconds)} computed, " if done.seconds else "nothing left to compute, "
    print(f"{computed}report: {done.report}")


def report(config: Path, *, results: Path = Path("results")) -> None:
    """Write the report of a finished study again, computing nothing.

    Parameters
    ----------
    config
        The study's TOML file.
    results
        Folder for all studies.
    """
    from ecfit.config import read_config

    read_config(config)
    from ecfit import study
    from ecfit.study.runner import write_results

    found = study.load(config, results)
    write_results(found)
    print(f"report: {found.report}")


def compare(old: Path, new: Path, *, tolerance: float = 0.01, coefficients: float = 1e-6) -> None:
    """Say what changed between two results folders of a study: tables, fits, errors, published results.

    Exits with 1 where a fit got worse, or a table, fit or published result is gone.

    Parameters
    ----------
    old, new
        Folders such as results/paper.
    tolerance
        Relative change of an error that counts.
    coefficients
        Change of a coefficient that counts, in units of the largest of its fit.
    """
    from ecfit.compare import compare as compare_

    found = compare_(old, new, tolerance=tolerance, coefficients=coefficients)
    print("\n".join(found.describe()))
    if found.worse:
        raise SystemExit(1)


def verify(folder: Path, *, entries: int = 1024, refits: int = 1, seed: int = 1) -> None:
    """Compute a sample of a study's results again and say whether they still hold.

    Exits with 1 where something does not. Plugins that the study's config names are imported.

    Parameters
    ----------
    folder
        Of the study, such as results/paper-small; its tables need not be there.
    entries
        Nodes of each table that are integrated again; a table that has no more is integrated whole.
    refits
        Fits that are made again, of tables that were integrated whole.
    seed
        Of what is drawn.
    """
    from ecfit.config import read_config

    read_config(folder / "config.toml")
    from ecfit.study.verify import verify as verify_

    done = verify_(folder, entries=entries, refits=refits, seed=seed)
    print("\n".join(done.describe()))
    if not done:
        raise SystemExit(1)
