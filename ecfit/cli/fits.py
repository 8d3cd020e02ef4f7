"""Fits: made, proven, shipped."""

from pathlib import Path
from typing import Any

from ecfit.cli.arguments import Plugins
from ecfit.cli.terminal import say
from ecfit.errors import EcfitError


def fit(
    table: Path,
    *,
    form: str = "rational",
    degree: int | None = None,
    numerator: int | None = None,
    denominator: int | None = None,
    guarded: bool = True,
    lower_bound: bool = False,
    output: Path | None = None,
) -> None:
    """Fit a form to a table; print its errors and, with --output, save coefficients and contract (JSON).

    Parameters
    ----------
    table
        A table written by `ecfit table`, `ecfit import` or a study.
    form
        rational or polynomial.
    degree
        Total degree.
    numerator, denominator
        Degrees of a rational, instead of degree.
    guarded
        Whether the denominator must keep its sign; without, the least-squares optimum may have a pole.
    lower_bound
        Also compute the least possible largest error of the form, and print the fit's in units of it.
    output
        File to write.
    """
    import ecfit
    from ecfit.forms import form as make_form

    given = {"degree": degree, "numerator": numerator, "denominator": denominator}
    settings: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if not guarded:
        settings["guarded"] = False
    if not any(value is not None for value in given.values()):
        raise EcfitError("fit needs --degree, or --numerator and --denominator")
    done = ecfit.fit(ecfit.Table.load(table), make_form(form, **settings), lower_bound=lower_bound)
    if not done.ok:
        say(f"WARNING: {done.warning()}")
    print("\n".join(done.describe()))
    if output is not None:
        done.save(output)
        print(f"written: {output}")


def certify(
    fit: str, *, plugin: Plugins = (), samples: int = 20_000, seed: int = 1, output: Path | None = None
) -> None:
    """Prove that a fit has no pole and stays in [0, 1] on its whole domain, and measure its errors.

    Exits with 1 where the certificate is refused.

    Parameters
    ----------
    fit
        A published or shipped fit by name (`ecfit list` shows them), or the JSON file of a fit.
    samples
        Random points at which the model is integrated for the errors.
    seed
        Of the random points.
    output
        File to write (JSON).
    """
    from ecfit.approximation import find
    from ecfit.certify import certify as certify_
    from ecfit.files import write_json
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    done = certify_(find(fit), samples=samples, seed=seed)
    print("\n".join(done.describe()))
    if output is not None:
        write_json(output, done.to_dict())
        print(f"written: {output}")
    if not done.certified:
        raise SystemExit(1)


def ship(config: Path, *, output: Path, results: Path = Path("results"), samples: int = 20_000) -> None:
    """Certify the named fits of a finished study and write those that are granted, one file each.

    Exits with 1 where a fit is refused.

    Parameters
    ----------
    config
        The study's TOML file; fits are shipped that have a name there.
    output
        Folder for the files; a name that is there with other coefficients is refused.
    results
        Folder for all studies.
    samples
        Random points at which the models are integrated.
    """
    from ecfit.config import read_config

    read_config(config)
    from ecfit.study import load, make_plan
    from ecfit.study.ship import Shipment
    from ecfit.study.ship import ship as ship_

    study = load(config, results)

    def told(shipment: Shipment) -> None:
        print("\n".join([*shipment.certificate.describe(), f"  {shipment.outcome}"]), flush=True)

    done = ship_(make_plan(study.config, config.parent), study.fits, output, samples=samples, told=told)
    if not all(shipment.shipped for shipment in done):
        raise SystemExit(1)
