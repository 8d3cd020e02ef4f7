"""Exported C, compiled and run: how far single precision is from the exact value of the same expression.

python benchmarks/export.py            prints the tables
python benchmarks/export.py --write    also writes them into docs/export.md
"""

import common
import numpy as np

from ecfit.approximation import find, published_names, shipped
from ecfit.export import code
from ecfit.export.code import default_name, expression
from ecfit.export.compiled import compiled
from ecfit.export.coordinates import arguments
from ecfit.export.ulps import exact, points, ulps
from ecfit.expressions import cost

DOCUMENT = common.DOCS / "export.md"
HEADER = ("fit", "operations", "within 4 ulps", "95 %", "worst", "worst at edges", "largest difference")


def table(names: list[str], count: int) -> str:
    """Rows for fits by name; all are compiled into one library.

    95 % and worst are in ulps at `count` points uniform in the arguments; edges are as many points of which
    half the arguments are at an end of the domain or near the lower one. The difference is of both.
    """
    fits = [find(name) for name in names]
    sources = [code(fit, "c") for fit in fits]
    functions = compiled(sources, [(default_name(fit), len(fit.variables)) for fit in fits])
    rows = []
    for name, fit, function in zip(names, fits, functions, strict=True):
        taken = arguments(fit, (), False)
        node = expression(fit, taken)
        off, largest = [], 0.0
        for edges in (False, True):
            at = points(taken, count, seed=1, edges=edges)
            found, truth = function(*at.values()), exact(node, at)
            if not np.all(np.isfinite(found)):
                raise SystemExit(f"{name} is not finite somewhere in its domain")
            off.append(ulps(found, truth))
            largest = max(largest, float(np.abs(found - truth).max()))
        inside, edge = off
        rows.append(
            (
                f"`{name}`", f"{cost(node).total:.0f}", f"{np.mean(inside <= 4.0):.1%}",
                f"{np.quantile(inside, 0.95):.1f}", f"{inside.max():.3g}", f"{edge.max():.3g}",
                f"{largest:.1e}",
            )
        )  # fmt: skip
    return common.markdown(HEADER, rows)


def main() -> None:
    """Print, and write if asked to."""
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/export.md")
    given = parser.parse_args()
    count = 2_000 if given.quick else 50_000
    found = {"shipped": table(shipped(), count), "published": table(published_names(), count)}
    if given.write:
        common.replace_between(DOCUMENT, "export.py", **found)
    print(*found.values(), sep="\n\n")


if __name__ == "__main__":
    main()
