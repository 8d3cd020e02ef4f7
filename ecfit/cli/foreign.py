"""Somebody's own tables: read to be fitted like ours, and audited."""

from pathlib import Path
from typing import Any, Literal

from ecfit.cli.arguments import GivenAxes, Options, Plugins, Spacing
from ecfit.cli.claims import Foreign, claim_of, read_foreign
from ecfit.cli.terminal import say
from ecfit.errors import refuse_ignored


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
    how = Foreign(axis, layout, piece, number, spacing, stored, scale, order, channel)
    contract = claim_of(model, option, quantity, lobe, transport, exponent, own=how.says_itself)
    done = read_foreign(file, how, contract)
    done.save(output)
    print("\n".join([*done.describe(), f"written: {output}"]))


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
    how = Foreign(axis, layout, piece, number, spacing, stored, scale, order, channel)
    what: Any = subject
    path = Path(subject)
    foreign = path.suffix.lower() in FORMATS
    contract = claim_of(model, option, quantity, lobe, transport, exponent, not foreign or how.says_itself)
    if foreign:
        what = read_foreign(path, how, contract, finite=False)
    else:
        refuse_ignored(f"'{subject}' says itself what it is", how._asdict())
    done = audit(
        what,
        contract=contract,
        name=subject,
        samples=samples,
        seed=seed,
        tolerance=tolerance,
        told=lambda trial: say(f"trying: {trial}"),
    )
    print("\n".join(done.describe()))
    if not done.ok:
        raise SystemExit(1)
