"""Audit somebody's table: is it what it is said to be, and if not, what went wrong?

    python examples/07_audit_a_table.py
    python examples/07_audit_a_table.py --output folder

Half of the errors of this field are conventions. Here is a colleague's table of the directional albedo of a
rough metal, `theirs.csv`, with the columns r, mu and value. THE PAGE WRITES IT ITSELF, WITH A MISTAKE: its
rows were computed for alpha, but the column is called r. No number in it is impossible, and a fit to it
would look good.

`ecfit.audit` integrates some of the entries again under the claimed conventions. Where they differ it
undoes one mistake after another until the numbers agree: that one is likely. Then the table is read as it
was meant, and audited once more. From the command line, the first of the two is

    ecfit check theirs.csv --axis r=12 --axis mu=12 --model conductor

Printed: both audits. The file is kept where --output says, else it is a temporary one.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import cyclopts

import ecfit

CLAIM = ecfit.Contract("conductor", {"masking": "separable"})


class Found(NamedTuple):
    """What the example found, for who imports it."""

    claimed: ecfit.Audit
    mended: ecfit.Audit


def theirs(nodes: int) -> str:
    """The text of a file as a colleague might send it: a line an entry, alpha in the column r."""
    table = ecfit.tabulate("conductor", {"alpha": nodes, "mu": nodes})
    alpha, mu = (axis.nodes for axis in table.axes)
    lines = [
        f"{a:.6f},{m:.6f},{table.values[i, k]:.6f}" for i, a in enumerate(alpha) for k, m in enumerate(mu)
    ]
    return "\n".join(["# directional albedo of a GGX metal, F = 1", "r,mu,value", *lines, ""])


def main(*, nodes: int = 12, output: Path | None = None) -> Found:
    """Write a table with a mistake, audit it, and read it as it was meant.

    Parameters
    ----------
    nodes
        Of the table, along each axis.
    output
        Folder for the file; without it a temporary one.
    """
    with TemporaryDirectory() as temporary:
        folder = output or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "theirs.csv"
        path.write_text(theirs(nodes), encoding="utf-8")

        claimed = ecfit.audit(ecfit.read_table(path, {"r": nodes, "mu": nodes}, CLAIM), name=path.name)
        print(claimed, end="\n\n")

        # The same numbers, as they were meant.
        values = ecfit.read_table(path, {"r": nodes, "mu": nodes}, CLAIM).values
    meant = ecfit.Table.from_array(values, {"alpha": nodes, "mu": nodes}, CLAIM, source=path.name)
    mended = ecfit.audit(meant, name=f"{path.name}, r read as alpha")
    print(mended)
    if output is not None:
        print(f"written: {path}")
    return Found(claimed, mended)


if __name__ == "__main__":
    cyclopts.run(main, result_action="return_none")
