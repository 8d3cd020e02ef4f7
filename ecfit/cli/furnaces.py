"""White furnaces, rendered or integrated."""

from pathlib import Path
from typing import Literal

from ecfit.cli.arguments import Axes, Options, Plugins, axes_of, options_of
from ecfit.cli.terminal import bars, say
from ecfit.errors import EcfitError, refuse_ignored

_TOLERANCE = 1e-6


def furnace(
    model: str,
    *,
    axis: Axes = (),
    albedo: str | None = None,
    method: Literal["turquin", "kulla-conty"] | None = None,
    option: Options = (),
    plugin: Plugins = (),
    transport: str | None = None,
    tolerance: float | None = None,
    output: Path | None = None,
    numerical: bool = False,
    results: Path | None = None,
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
        turquin (the default) scales the model; kulla-conty adds a diffuse lobe.
    transport
        energy (the default), or radiance for the albedos of such tables.
    tolerance
        Absolute error of each integral (1e-6).
    output
        File for the table of integrals (NPZ).
    numerical
        Of a config: integrate one scattering of each material instead of rendering it. Models always are.
    results
        Of a config: folder of all results ("results").
    """
    of_model = {
        "--axis": axis, "--albedo": albedo, "--method": method, "--option": option, "--plugin": plugin,
        "--transport": transport, "--tolerance": tolerance, "--output": output,
    }  # fmt: skip
    if model.endswith(".toml"):
        refuse_ignored("a furnace's config says this itself", of_model)
        return _pictures(Path(model), results or Path("results"), numerical)
    refuse_ignored(
        "only a furnace's config takes this", {"--numerical": numerical or None, "--results": results}
    )
    method, transport = method or "turquin", transport or "energy"
    tolerance = _TOLERANCE if tolerance is None else tolerance
    if not axis:
        raise EcfitError("the furnace of a model needs --axis: for example --axis r=32 --axis mu=0.1:1:32")
    import ecfit
    from ecfit.approximation import find
    from ecfit.compensation import furnace_of
    from ecfit.quantities import quantity as make_quantity
    from ecfit.study.plugins import load_plugins

    load_plugins(plugin, Path())
    bsdf = ecfit.model(model, **options_of(option))
    given = None if albedo is None else find(albedo)
    axes, _ = axes_of(axis, bsdf, make_quantity("directional-albedo", "all", transport), "uniform")
    found = furnace_of(bsdf, given, axes, method=method, transport=transport, tolerance=tolerance)
    print("\n".join(found.describe()))
    if output is not None:
        found.table.save(output)
        print(f"written: {output}")


def _pictures(config: Path, results: Path, numerical: bool) -> None:
    """`ecfit furnace CONFIG`."""
    from ecfit.config.furnace import read_furnace

    read_furnace(config)  # a fault in the file is told before JAX takes its second to load
    if numerical:
        from ecfit.rendering.numerical import run_numerical

        done = run_numerical(config, results, progress=bars())
        print("\n".join([*done.describe(), f"written: {done.file}"]))
        return
    from ecfit.rendering.run import run_furnace

    found = run_furnace(config, results, progress=bars(), told=say)
    print("\n".join(found.describe()))
    print(f"{found.computed} rendered, {len(found.rendered) - found.computed} found; page: {found.page}")
