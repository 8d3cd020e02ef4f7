"""Tables: integrated, and written as renderers store them."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ecfit.cli.arguments import Axes, Options, Plugins, Spacing, axes_of, counts_of, options_of, plain_axes
from ecfit.cli.terminal import bars, say


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
    bsdf = ecfit.model(model, **options_of(option))
    settings = {} if exponent is None else {"exponent": exponent}
    axes, total = axes_of(axis, bsdf, make_quantity(quantity, lobe, transport, **settings), spacing)
    with bars().stage("table", total) as advance:
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
        axes=plain_axes(axis, spacing) if layout == "plain" else counts_of(axis),
        spacing=spacing,
        options=options_of(option),
        transport=transport,
        lobe=lobe,
        quantity=quantity,
        tolerance=tolerance,
        progress=bars(),
    )
    names = None if order is None else [part.strip() for part in order.split(",")]
    written = done.save(output, number=number, stored=stored, order=names, name=name, parts=parts)
    for remark in done.remarks():
        say(f"WARNING: {remark}")
    for table in done.tables:
        print(", ".join(f"{label} {value}" for label, value in table.contract.describe()[:-2]))
    print("\n".join(written.describe()))
