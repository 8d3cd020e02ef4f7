"""The command line. JAX is imported inside the commands only, so that help and mistakes answer at once."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, NoReturn

from cyclopts import App, CycloptsError, Parameter

from ecfit._cache import keep_compiled
from ecfit.errors import EcfitError, refuse_ignored

# Before NumPy loads: JAX has a pool of threads of its own, and where two pools share the cores small
# factorisations take up to a hundred times longer (docs/performance.md).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

app = App(
    name="ecfit",
    help="From a BSDF to albedo tables with error estimates, rational fits and reports.",
    version=lambda: import_module("ecfit").__version__,
    version_flags=["--version"],
    # Rich text in help would cost 0.1 s at every start.
    help_format="plaintext",
    # `main` says how to go on; cyclopts would end without a word.
    suppress_keyboard_interrupt=False,
)

Plugins = Annotated[
    tuple[str, ...],
    Parameter(name="--plugin", help="Python file or module that registers models; repeatable."),
]
Axes = Annotated[
    tuple[str, ...],
    Parameter(
        name="--axis", help="name=count, or name=low:high:count, in the order of the dimensions; repeatable."
    ),
]
GivenAxes = Annotated[
    tuple[str, ...],
    Parameter(name="--axis", help="name=count (0 to 1), name=low:high:count or name=x,x,...; repeatable."),
]
Spacing = Literal["uniform", "gauss", "chebyshev", "texel-centre", "clamped"]
Options = Annotated[
    tuple[str, ...], Parameter(name="--option", help="A setting of the model, name=value; repeatable.")
]


@app.command
def run(
    config: Path,
    *,
    results: Annotated[Path, Parameter(help="Folder for all studies.")] = Path("results"),
    workers: int | None = None,
) -> None:
    """Run a study: tables, fits and report. Finished parts are kept; running again resumes.

    Parameters
    ----------
    config
        The study's TOML file.
    workers
        Processes that fit at most, a table each; by default the processors that may be used.
    """
    from ecfit.config import read_config
    from ecfit.workers import check_workers

    check_workers(workers)
    read_config(config)  # a fault in the file is told before JAX takes its second to load
    from ecfit import study

    done = study.run(config, results, workers=workers, progress=_bars())
    for warning in done.warnings():
        _say(f"WARNING: {warning}")
    for name, fits in done.fits.items():
        for found in fits:
            if found.least_max_error is not None:
                print(f"table {name}: {found.approximation.name}: {found.least_line()}")
    computed = f"{len(done.seconds)} computed, " if done.seconds else "nothing left to compute, "
    print(f"{computed}report: {done.report}")


@app.command
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


@app.command
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


@app.command
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


@app.command
def table(
    model: str,
    *,
    output: Path,
    axis: Axes,
    option: Options = (),
    plugin: Plugins = (),
    quantity: str = "directional-albedo",
    lobe: str = "all",
    transport: str = "energy",
    tolerance: float = 1e-7,
    spacing: Spacing = "uniform",
    exponent: int | None = None,
) -> None:
    """Integrate a quantity of a model on a grid and save the table (NPZ).

    Parameters
    ----------
    model
        A registered model; `ecfit list` shows them.
    output
        File to write.
    quantity
        What is integrated; `ecfit list` shows them.
    lobe
        all, reflection or transmission.
    transport
        energy or radiance.
    tolerance
        Absolute error to reach in every entry.
    spacing
        Of the nodes of all axes.
    exponent
        Of schlick-a and schlick-b; 5 by default.
    """
    import ecfit
    from ecfit.quantities import quantity as make_quantity
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    bsdf = ecfit.model(model, **_settings(option))
    settings = {} if exponent is None else {"exponent": exponent}
    axes, total = _axes(axis, bsdf, make_quantity(quantity, lobe, transport, **settings), spacing)
    with _bars().stage("table", total) as advance:
        done = ecfit.tabulate(
            bsdf,
            axes,
            quantity=quantity,
            lobe=lobe,
            transport=transport,
            tolerance=tolerance,
            quantity_options=settings,
            progress=advance,
        )
    done.save(output)
    print("\n".join([*done.describe(), f"written: {output}"]))


@app.command(name="import")
def import_(
    file: Path,
    *,
    output: Path,
    axis: GivenAxes = (),
    layout: str | None = None,
    piece: str | None = None,
    number: str | None = None,
    spacing: Spacing | None = None,
    stored: Literal["E", "1-E"] | None = None,
    scale: float | None = None,
    order: str | None = None,
    channel: str | None = None,
    model: str | None = None,
    option: Options = (),
    plugin: Plugins = (),
    quantity: str | None = None,
    lobe: str | None = None,
    transport: str | None = None,
    exponent: int | None = None,
) -> None:
    """Read somebody's own table (CSV, NPY, EXR, C, raw) and save it as ours (NPZ), to be fitted like ours.

    Parameters
    ----------
    file
        The file; nothing in it is executed. One of `ecfit export-table` (EXR, CSV, C) says itself what it is.
    output
        File to write.
    layout
        A consumer's layout in the place of what follows, `ecfit list` shows them; --axis then gives counts.
    piece
        Of a layout with several tables that follow each other.
    number
        Type of the numbers of a raw file: float64, float32, float16, uint16, uint8.
    spacing
        Of the nodes of all axes: uniform, the default, has nodes at both ends, texel-centre at (i + 0.5) / N.
    stored
        What the file holds; E by default.
    scale
        The stored number that stands for 1: 65535 for 16-bit tables; 1 by default.
    order
        Axes as the file stores them, separated by commas, the one that varies fastest last; -mu: from its
        last node to its first (--order=-mu,r). By default the order of --axis.
    channel
        Of an image (R or Y by default), of the last dimension of an NPY array, or a column's name.
    model
        The registered model that the table is claimed to be of, or unknown.
    quantity
        What the table holds, directional-albedo by default; `ecfit list` shows the names.
    lobe
        all, reflection or transmission; all by default.
    transport
        energy or radiance; energy by default.
    exponent
        Of schlick-a and schlick-b; 5 by default.
    """
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    how = _Foreign(axis, layout, piece, number, spacing, stored, scale, order, channel)
    contract = _claim(model, option, quantity, lobe, transport, exponent, own=how.says_itself)
    done = _foreign(file, how, contract)
    done.save(output)
    print("\n".join([*done.describe(), f"written: {output}"]))


@app.command(name="export-table")
def export_table(
    source: Annotated[tuple[str, ...], Parameter(help="A model, or tables and fits, one a channel.")],
    /,
    *,
    output: Path,
    layout: str = "plain",
    axis: Axes = (),
    option: Options = (),
    plugin: Plugins = (),
    quantity: str | None = None,
    lobe: str | None = None,
    transport: str | None = None,
    tolerance: float | None = None,
    number: str | None = None,
    stored: Literal["E", "1-E"] | None = None,
    order: str | None = None,
    spacing: Spacing | None = None,
    name: str | None = None,
    parts: bool = False,
) -> None:
    """Write a table as a renderer stores it: EXR, NPY, CSV, C source (.h) or raw numbers (.bin).

    Parameters
    ----------
    source
        A registered model, which is integrated on the layout's nodes; or a table (NPZ), a published or
        shipped fit or the JSON file of one, for each channel of the layout.
    output
        File to write; its ending says the format.
    layout
        How the consumer stores it; `ecfit list` shows the layouts. plain has the axes given here.
    quantity
        What a model is integrated to where the layout leaves it open, directional-albedo by default.
    lobe
        all, reflection or transmission; all by default.
    transport
        energy or radiance; energy by default.
    tolerance
        Absolute error of a model's integrals to reach in every entry, 1e-7 by default.
    number
        float64, float32, float16, uint16 or uint8, in the place of the layout's.
    stored
        E or 1-E, in the place of the layout's.
    order
        Of plain: axes as they are to be stored, the one that varies fastest last; -mu: from last to first.
    spacing
        Of the nodes of plain axes, uniform by default.
    name
        Of the array in C source, ecfit_table by default.
    parts
        In EXR, put slices of 3D tables into parts instead of below each other.
    """
    from ecfit.baking import bake
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    done = bake(
        source,
        layout,
        axes=_plain_axes(axis, spacing) if layout == "plain" else _counts(axis),
        spacing=spacing,
        options=_settings(option),
        transport=transport,
        lobe=lobe,
        quantity=quantity,
        tolerance=tolerance,
        progress=_bars(),
    )
    names = None if order is None else [part.strip() for part in order.split(",")]
    written = done.save(output, number=number, stored=stored, order=names, name=name, parts=parts)
    for remark in done.remarks():
        _say(f"WARNING: {remark}")
    for table in done.tables:
        print(", ".join(f"{label} {value}" for label, value in table.contract.describe()[:-2]))
    print("\n".join(written.describe()))


@app.command
def check(
    subject: str,
    *,
    axis: GivenAxes = (),
    layout: str | None = None,
    piece: str | None = None,
    number: str | None = None,
    spacing: Spacing | None = None,
    stored: Literal["E", "1-E"] | None = None,
    scale: float | None = None,
    order: str | None = None,
    channel: str | None = None,
    model: str | None = None,
    option: Options = (),
    plugin: Plugins = (),
    quantity: str | None = None,
    lobe: str | None = None,
    transport: str | None = None,
    exponent: int | None = None,
    samples: int = 256,
    seed: int = 1,
    tolerance: float | None = None,
) -> None:
    """Audit a table or a fit: integrate entries again, and name the mistake of convention where they differ.

    Exits with 1 where the subject is not what it claims to be.

    Parameters
    ----------
    subject
        A table (NPZ of ecfit, or somebody's CSV, NPY, EXR, C source or raw file), a published or shipped
        fit by name, or the JSON file of a fit.
    layout
        Of somebody's file; `ecfit list` shows them. Else --axis and what follows, as in `ecfit import`.
    piece
        Of a layout with several tables that follow each other.
    number
        Type of the numbers of a raw file.
    spacing
        Of the nodes of --axis, uniform by default.
    stored
        What the file holds; E by default.
    scale
        The stored number that stands for 1; 1 by default.
    order
        Axes as the file stores them, the one that varies fastest last.
    channel
        Of an image, of the last dimension of an array, a column's or an array's name.
    model
        What the subject is claimed to be, in the place of its own contract, with --option, --quantity, --lobe
        and --transport.
    quantity
        What it is claimed to hold, directional-albedo by default.
    lobe
        all, reflection or transmission; all by default.
    transport
        energy or radiance; energy by default.
    exponent
        Of schlick-a and schlick-b; 5 by default.
    samples
        Entries that are integrated again.
    seed
        Of the choice of entries.
    tolerance
        Largest difference that is allowed; by default what the subject states, else 1e-3 (a fit: 5e-2).
    """
    from ecfit.auditing import audit
    from ecfit.study.plugins import load_plugins
    from ecfit.tables.foreign import FORMATS

    load_plugins(plugin, Path())
    how = _Foreign(axis, layout, piece, number, spacing, stored, scale, order, channel)
    what: Any = subject
    path = Path(subject)
    foreign = path.suffix.lower() in FORMATS
    contract = _claim(model, option, quantity, lobe, transport, exponent, not foreign or how.says_itself)
    if foreign:
        what = _foreign(path, how, contract, finite=False)
    else:
        refuse_ignored(f"'{subject}' says itself what it is", how._asdict())
    done = audit(
        what,
        contract=contract,
        name=subject,
        samples=samples,
        seed=seed,
        tolerance=tolerance,
        told=lambda trial: _say(f"trying: {trial}"),
    )
    print("\n".join(done.describe()))
    if not done.ok:
        raise SystemExit(1)


@app.command
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
        _say(f"WARNING: {done.warning()}")
    print("\n".join(done.describe()))
    if output is not None:
        done.save(output)
        print(f"written: {output}")


@app.command
def furnace(
    model: str,
    *,
    axis: Axes = (),
    albedo: str | None = None,
    method: Literal["turquin", "kulla-conty"] = "turquin",
    option: Options = (),
    plugin: Plugins = (),
    transport: str = "energy",
    tolerance: float = 1e-6,
    output: Path | None = None,
    numerical: bool = False,
    results: Path = Path("results"),
) -> None:
    """The white furnace, which should give 1: rendered from a config, or a model integrated over all light.

    Parameters
    ----------
    model
        The TOML file of a furnace, whose spheres Mitsuba 3 renders (configs/furnace.toml); or a registered
        model, integrated on the grid of --axis: a white conductor, a dielectric, glossy (over a white diffuse
        base), your own.
    albedo
        What compensates: a published fit or the JSON file of a fit; the exact integral by default.
    method
        turquin scales the model; kulla-conty adds a diffuse lobe.
    transport
        energy, or radiance for the albedos of such tables.
    tolerance
        Absolute error of each integral.
    output
        File for the table of integrals (NPZ).
    numerical
        Of a config: integrate one scattering of each material instead of rendering it. Models always are.
    results
        Of a config: folder of all results.
    """
    if model.endswith(".toml"):
        return _pictures(Path(model), results, numerical)
    if not axis:
        raise EcfitError("the furnace of a model needs --axis: for example --axis r=32 --axis mu=0.1:1:32")
    import ecfit
    from ecfit.approximation import find
    from ecfit.compensation import furnace_of
    from ecfit.quantities import quantity as make_quantity
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    bsdf = ecfit.model(model, **_settings(option))
    given = None if albedo is None else find(albedo)
    axes, _ = _axes(axis, bsdf, make_quantity("directional-albedo", "all", transport), "uniform")
    found = furnace_of(bsdf, given, axes, method=method, transport=transport, tolerance=tolerance)
    print("\n".join(found.describe()))
    if output is not None:
        found.table.save(output)
        print(f"written: {output}")


@app.command
def certify(fit: str, *, samples: int = 20_000, seed: int = 1, output: Path | None = None) -> None:
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

    done = certify_(find(fit), samples=samples, seed=seed)
    print("\n".join(done.describe()))
    if output is not None:
        write_json(output, done.to_dict())
        print(f"written: {output}")
    if not done.certified:
        raise SystemExit(1)


@app.command
def export(
    fit: str,
    *,
    lang: str,
    name: str | None = None,
    output: Path | None = None,
    coordinates: str = "",
    clamp: bool = False,
    factor: bool = False,
    least: float | None = None,
    derivative: str = "",
) -> None:
    """Write a fit as source code of a language, with its contract in a comment.

    Parameters
    ----------
    fit
        A published or shipped fit by name (`ecfit list` shows them), a fit's JSON file, or a table (NPZ).
    lang
        glsl, hlsl, wgsl, msl, slang, osl, c, cpp, python, or materialx: a library of several files.
    name
        Of the function; by default the fit's.
    output
        File to write, folder for materialx; without, the code is printed.
    coordinates
        Views that it takes, separated by commas: r or alpha, F0 or ior. By default those of the fit.
    clamp
        Clamp the arguments to the domain.
    factor
        Also a function for 1 / E, and for conductors one for 1 + F0 (1 / E - 1) with a colour F0.
    least
        E is raised to this where 1 / E is meant; 1/32 by default.
    derivative
        Also a function for the slope by this argument.
    """
    from ecfit.export import Options, source, write

    views = tuple(v.strip() for v in coordinates.split(",") if v.strip())
    approximation, evidence = source(fit)
    given = {} if least is None else {"least": least}
    options = Options(name, views, clamp, factor, derivative=derivative, evidence=evidence, **given)
    print(write(approximation, lang, options, output))


@app.command
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


@app.command
def check_export(
    *fits: str,
    tool: Annotated[
        tuple[str, ...], Parameter(help="Tool to use; repeatable. By default all there are.")
    ] = (),
    points: int = 4096,
) -> None:
    """Compile and run exported code with the compilers and devices of this machine, and compare with NumPy.

    Exit code 1 where a value is not finite, or farther from the exact one than twice NumPy's float32.

    Parameters
    ----------
    fits
        Names of fits or their JSON files; by default all shipped fits.
    points
        How many in the closed domain of each, corners and edges included.
    """
    from ecfit.approximation import find, shipped
    from ecfit.shaders import TOOLS, check_all
    from ecfit.shaders import tool as named

    found = [find(fit) for fit in fits or shipped()]
    tools = [named(t) for t in tool] or list(TOOLS.values())
    failed = False
    for report in check_all(found, tools, points):
        print(report.describe(), flush=True)
        failed |= not report.passes
    if failed:
        raise SystemExit(1)


@app.command
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


@app.command(name="check-bsdf")
def check_bsdf(model: str, *, option: Options = (), plugin: Plugins = (), samples: int = 500) -> None:
    """Check a model: finite, non-negative, reciprocal, energy <= 1, clean under jit, vmap and grad.

    Exits with 1 where a property fails.

    Parameters
    ----------
    model
        A registered model.
    samples
        Directions tried for each setting of the parameters.
    """
    import ecfit
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    if samples < 1:
        raise EcfitError(f"samples must be 1 or more, got {samples}")
    found = ecfit.check_bsdf(ecfit.model(model, **_settings(option)), samples=samples)
    print(found)
    if not found:
        raise SystemExit(1)


@app.command(name="list")
def list_(*, plugin: Plugins = ()) -> None:
    """List models with their options and parameters, quantities, forms, spacings and published fits."""
    from ecfit.approximation import published, published_names, shipped
    from ecfit.bsdf import models
    from ecfit.contract import QUANTITIES
    from ecfit.coordinates import SPACINGS, VIEWS
    from ecfit.forms import forms, registered_forms
    from ecfit.study.plugins import load_plugins
    from ecfit.tables import LAYOUTS

    load_plugins(plugin, Path())
    print("models")
    for name, cls in sorted(models().items()):
        print(f"  {name}: {(cls.__doc__ or '').strip().splitlines()[0] if cls.__doc__ else ''}")
        for key, choices in cls.option_choices().items():
            print(f"    {key} = {' | '.join(choices)}")
        for key, (low, high) in cls.parameter_ranges().items():
            others = [v.name for v in VIEWS.values() if v.of == key]
            print(f"    {key} in [{low:g}, {high:g}]" + (f" (or {', '.join(others)})" if others else ""))
    print("quantities")
    for name, text in QUANTITIES.items():
        print(f"  {name}: {text}")
    print("forms")
    for name, cls in forms().items():
        print(f"  {name}: {(cls.__doc__ or '').strip().splitlines()[0]}")
    print('modules (form = "module")')
    for name, made in sorted(registered_forms().items()):
        print(f"  {name}: {(made.__doc__ or '').strip().partition(chr(10))[0]}")
    print("spacings")
    for name, text in SPACINGS.items():
        print(f"  {name}: {text}")
    print("layouts of tables")
    for layout in LAYOUTS.values():
        print("\n".join(f"  {line}" for line in layout.describe()))
    print("shipped fits")
    for name in shipped():
        found = shipped(name)
        ends = ", ".join(
            f"{v} in [{a:g}, {b:g}]" for v, (a, b) in zip(found.variables, found.domain, strict=True)
        )
        print(f"  {name}: {found.contract.model}, {found.contract.quantity}, {ends}")
    print("published fits")
    for name in published_names():
        print(f"  {name}: {published(name).source}")


def _pictures(config: Path, results: Path, numerical: bool) -> None:
    """`ecfit furnace CONFIG`."""
    from ecfit.config.furnace import read_furnace

    read_furnace(config)  # a fault in the file is told before JAX takes its second to load
    if numerical:
        from ecfit.rendering.numerical import run_numerical

        done = run_numerical(config, results, progress=_bars())
        print("\n".join([*done.describe(), f"written: {done.file}"]))
        return
    from ecfit.rendering.run import run_furnace

    found = run_furnace(config, results, progress=_bars(), told=_say)
    print("\n".join(found.describe()))
    print(f"{found.computed} rendered, {len(found.rendered) - found.computed} found; page: {found.page}")


def _settings(pairs: tuple[str, ...]) -> dict[str, Any]:
    """name=value pairs; a value that reads as a number is one."""
    out: dict[str, Any] = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not equals or not name or not value:
            raise EcfitError(f"expected name=value, got '{pair}'")
        try:
            out[name] = float(value)
        except ValueError:
            out[name] = value
    return out


def _axes(texts: tuple[str, ...], model: Any, quantity: Any, spacing: str) -> tuple[dict[str, Any], int]:
    """Axes of `--axis` arguments by name, and the number of entries of their grid."""
    import ecfit
    from ecfit.tables.tabulate import default_range

    axes: dict[str, Any] = {}
    total = 1
    for text in texts:
        name, low, high, count = _axis(text)
        low, high = default_range(model, quantity, name, (low, high))
        axes[name] = ecfit.Axis.spaced(name, count, low, high, spacing)
        total *= count
    return axes, total


def _given_axes(texts: tuple[str, ...], spacing: str | None) -> dict[str, Any]:
    """Axes of `ecfit import` by name."""
    import ecfit
    from ecfit.tables.given import full_range

    if all("," in text for text in texts):
        refuse_ignored("nodes that are listed have no spacing", {"spacing": spacing})
    axes: dict[str, Any] = {}
    for text in texts:
        name, _, value = text.partition("=")
        if "," in value:
            axes[name] = ecfit.Axis.given(name, value.split(","))
        else:
            name, low, high, count = _axis(text)
            axes[name] = ecfit.Axis.spaced(name, count, *full_range(name, low, high), spacing or "uniform")
    return axes


def _plain_axes(texts: tuple[str, ...], spacing: str | None) -> dict[str, Any]:
    """Axes of `ecfit export-table` by name: counts, whose range is that of the model, or whole axes."""
    import ecfit

    axes: dict[str, Any] = {}
    for text in texts:
        name, low, high, count = _axis(text)
        whole = low is not None and high is not None
        axes[name] = ecfit.Axis.spaced(name, count, low, high, spacing or "uniform") if whole else count
    return axes


class _Foreign(NamedTuple):
    """How somebody's file is to be read: the options of `ecfit import`."""

    axis: tuple[str, ...]
    layout: str | None
    piece: str | None
    number: str | None
    spacing: str | None
    stored: Literal["E", "1-E"] | None
    scale: float | None
    order: str | None
    channel: str | None

    @property
    def says_itself(self) -> bool:
        """Whether the file or its layout says what it is; else its axes are given."""
        return self.layout is not None or not self.axis


def _foreign(file: Path, how: _Foreign, contract: Any, finite: bool = True) -> Any:
    """A table from somebody's file: by its axes, by a layout's name, or by what it says of itself."""
    from ecfit.contract import Contract
    from ecfit.tables import read_layout, read_table

    if how.says_itself:
        counts = _counts(how.axis)
        done = read_layout(file, how.layout, contract=contract, counts=counts, channel=how.channel,
                           piece=how.piece, finite=finite)  # fmt: skip
        who = f"'{file}'" if how.layout is None else f"layout '{how.layout}'"
        said = how._asdict()
        stored = {k: said[k] for k in ("number", "spacing", "stored", "scale", "order")}
        refuse_ignored(f"{who} says itself how numbers are stored", stored)
        return done
    refuse_ignored("pieces are of a layout", {"piece": how.piece})
    if file.suffix.lower() in (".npy", ".exr"):
        refuse_ignored(f"a {file.suffix} file says the type of its numbers", {"number": how.number})
    names = None if how.order is None else [name.strip() for name in how.order.split(",")]
    axes = _given_axes(how.axis, how.spacing)
    scale = 1.0 if how.scale is None else how.scale
    return read_table(file, axes, contract or Contract("unknown"), how.stored, names, channel=how.channel,
                      scale=scale, number=how.number, finite=finite)  # fmt: skip


def _claim(
    model: str | None,
    option: tuple[str, ...],
    quantity: str | None,
    lobe: str | None,
    transport: str | None,
    exponent: int | None,
    own: bool,
) -> Any:
    """The contract that the options of `ecfit import` say, or None where they say none.

    `own`: whether the subject has a contract of its own, which only a whole one replaces.
    """
    from ecfit.tables import claim

    said = {"quantity": quantity, "lobe": lobe, "transport": transport}
    if model is None and own:
        why = "what the subject says of itself holds unless a model is claimed too (--model unknown for any)"
        refuse_ignored(why, {"option": option, **said, "exponent": exponent})
    if model is None and not option and exponent is None and all(v is None for v in said.values()):
        return None
    settings = {} if exponent is None else {"exponent": exponent}
    return claim(
        model or "unknown",
        _settings(option),
        quantity or "directional-albedo",
        lobe or "all",
        transport or "energy",
        settings,
    )


def _counts(texts: tuple[str, ...]) -> dict[str, int]:
    """Counts of `--axis name=count` by name."""
    out = {}
    for text in texts:
        name, low, high, count = _axis(text)
        if low is not None or high is not None:
            raise EcfitError(f"a layout has its own ranges: give --axis {name}={count}")
        out[name] = count
    return out


def _axis(text: str) -> tuple[str, float | None, float | None, int]:
    """(name, low, high, count) of `name=count` or `name=low:high:count`."""
    name, _, value = text.partition("=")
    parts = value.split(":")
    try:
        if name and len(parts) == 1:
            return name, None, None, int(parts[0])
        if name and len(parts) == 3:
            return name, float(parts[0]), float(parts[1]), int(parts[2])
    except ValueError:
        pass
    raise EcfitError(f"expected an axis name=count or name=low:high:count, got '{text}'")


def _bars() -> Any:
    """Progress bars on the terminal (one line where there is none)."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    class Bars:
        @contextmanager
        def stage(self, title: str, total: int) -> Iterator[Callable[[int], None]]:
            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            with Progress(*columns, console=Console(stderr=True)) as progress:
                task = progress.add_task(title, total=total)
                yield lambda steps: progress.advance(task, steps)

    return Bars()


def _say(text: str) -> None:
    print(text, file=sys.stderr)


def _fail(text: str, code: int = 2) -> NoReturn:
    _say(text)
    raise SystemExit(code)


def main(arguments: list[str] | None = None) -> None:
    """Entry point: a mistake is one message and exit code 2; an interrupt says how to go on (130)."""
    keep_compiled()
    try:
        app(arguments, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        _fail(f"error: {' '.join(str(error).split())}; see ecfit --help")
    except EcfitError as error:
        _fail(f"error: {error}")
    except KeyboardInterrupt:
        _fail("stopped; what is finished is kept: the same command goes on from here", 130)
    except MemoryError:
        _fail("error: out of memory: use fewer nodes an axis")
    except BrokenPipeError:
        raise SystemExit(0) from None
