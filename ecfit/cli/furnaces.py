"""White furnaces, rendered or integrated."""

from pathlib import Path
from typing import Literal

from ecfit.cli.arguments import Axes, Options, Plugins, axes_of, options_of
from ecfit.cli.terminal import bars, say
from ecfit.errors import EcfitError


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
