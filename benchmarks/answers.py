"""The last table of docs/published-fits.md: every printed fit, and what of ours stands in its place.

    python benchmarks/answers.py --cache .published             # on the screen; --quick: 300 points
    python benchmarks/answers.py --cache .published --write     # into the document

benchmarks/answers.toml says which fit answers which. Errors are those at the points of
benchmarks/published.py, under the contract of the printed fit, whatever ours was made for.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import common
import numpy as np
import published
from choosing import Truth

from ecfit.approximation import Approximation, find
from ecfit.certify.truth import LOOSE
from ecfit.coordinates import viewed
from ecfit.errors import EcfitError
from ecfit.expressions import Cost, Node, cost, parse, substitute, value
from ecfit.expressions.node import inputs
from ecfit.forms.features import COORDINATES, FEATURES, plain

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(__file__).with_suffix(".toml")
HEADER = (
    "printed", "numbers", "operations", "MAE", "largest", "ours", "numbers", "operations", "MAE", "largest",
    "nearer: MAE", "largest", "verdict",
)  # fmt: skip
# What is claimed for a fit that answers another: at least the first, at best the second.
LEAST, TARGET = 2.0, 5.0
# Words for what costs more than a multiply-add.
SHORT = {"divisions": "div", "roots": "root", "transcendentals": "exp", "comparisons": "cmp"}


@dataclass(frozen=True)
class Answer:
    """What stands in the place of a printed fit.

    Attributes:
        name: for people; root: the value in coordinates; count: its numbers.
        note: what else is to be said.
    """

    name: str
    root: Node
    count: int
    note: str = ""

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> "Answer":
        """From an entry of the data file. Raises `EcfitError` for fits that are not there."""
        note = entry.get("note", "")
        if "ours" in entry:
            fit = found(entry["ours"])
            return cls(f"`{Path(entry['ours']).stem}`", fit.expression(), fit.count, note)
        parts = {name: found(fit) for name, fit in entry["parts"].items()}
        lets = [(str(name), str(text)) for name, text in entry.get("let", [])]
        features = {name: plain(name) for name in FEATURES if name not in parts}
        known = [*COORDINATES, *(n for n in features if n not in COORDINATES), *parts]
        text = parse(entry["text"], known, lets)
        root = substitute(text, {**features, **{name: fit.expression() for name, fit in parts.items()}})
        label = " + ".join(f"`{Path(name).stem}`" for name in entry["parts"].values())
        return cls(label, root, sum(fit.count for fit in parts.values()), note)

    def errors(self, points: published.Points, truth: published.Scattered) -> tuple[float, float]:
        """MAE and largest error where the truth is known."""
        views = ((n, viewed(n, given, p)) for n in inputs(self.root) for given, p in points.items())
        at = {name: np.asarray(p) for name, p in views if p is not None}
        usable = np.isfinite(truth.values) & (truth.errors <= LOOSE)
        with np.errstate(all="ignore"):
            error = np.abs(np.asarray(value(self.root, at)) - truth.values)[usable]
        return float(error.mean()), float(error.max())


def found(name: str) -> Approximation:
    """A shipped or published fit by name, or from a file of the repository."""
    return find(str(ROOT / name) if name.endswith(".json") else name)


def entries() -> dict[str, list[dict[str, Any]]]:
    """Printed fit -> its answers, as the data file has them."""
    return tomllib.loads(DATA.read_text())


def dearest(spent: Cost) -> int:
    """0: products and sums; 1: divisions and roots, too; 2: exponentials, logarithms or powers."""
    return 2 if spent.transcendentals else int(bool(spent.divisions or spent.roots))


def operations(spent: Cost) -> str:
    """In a few letters: 19 ma, 1 div, 2 root."""
    rest = [f"{n} {SHORT[kind]}" for kind in SHORT if (n := getattr(spent, kind))]
    return ", ".join([f"{spent.multiply_adds} ma", *rest])


def times(ratio: float) -> str:
    """How much nearer, in two digits."""
    return "exact" if ratio > 1e6 else f"{ratio:.0f}" if ratio >= 9.5 else f"{ratio:.1f}"


def verdict(printed: Approximation, ours: Answer, ratio: float) -> str:
    """What is to be claimed, and what it costs."""
    claim = f">= {TARGET:g}" if ratio >= TARGET else f">= {LEAST:g}" if ratio >= LEAST else "below 2"
    words = [claim]
    words += [f"{ours.count} numbers"] if ours.count > printed.count else []
    words += ["dearer functions"] if dearest(cost(ours.root)) > dearest(cost(printed.expression())) else []
    words += [ours.note] if ours.note else []
    return "; ".join(words)


def row(
    printed: Approximation, entry: Mapping[str, Any], points: published.Points, truth: published.Scattered
) -> tuple[str, ...]:
    """One line of the table."""
    part = entry.get("within", {})
    inside = np.all([(lo <= points[n]) & (points[n] <= hi) for n, (lo, hi) in part.items()], axis=0)
    points = {n: p[inside] for n, p in points.items()} if part else points
    truth = published.Scattered(*(v[inside] for v in truth)) if part else truth
    where = "".join(f", {n} in [{lo:g}, {hi:g}]" for n, (lo, hi) in part.items())
    own = Answer(f"`{printed.name}`{where}", printed.expression(), printed.count)
    theirs = own.errors(points, truth)
    head = (own.name, str(own.count), operations(cost(own.root)), *map(published.number, theirs))
    if theirs[1] < published.EXACT:
        return (*head, *("-",) * 7, "an exact identity")
    if "no" in entry:
        return (*head, *("-",) * 7, entry["no"])
    ours = Answer.of(entry)
    errors = ours.errors(points, truth)
    ratios = [
        a / max(b, 1e-300) if b >= published.EXACT else np.inf for a, b in zip(theirs, errors, strict=True)
    ]
    return (
        *head, ours.name, str(ours.count), operations(cost(ours.root)), *map(published.number, errors),
        *map(times, ratios), verdict(printed, ours, min(ratios)),
    )  # fmt: skip


def table(truths: Truth, count: int) -> str:
    """All printed fits, in the order of the document."""
    data, rows = entries(), {name: [] for name in published.SECTIONS}
    for group in published.groups(lookups=False):
        points = group.points(min(count, published.FEWER.get(group.contract.quantity, count)))
        try:
            truth = published.integrals(truths, group.contract, points)
        except EcfitError:
            lines = [
                (f"`{f.name}`", str(f.count), *("-",) * 10, data[f.name][0]["no"]) for f in group.members
            ]
        else:
            lines = [row(f, e, points, truth) for f in group.members for e in data.get(f.name, [{}])]
        rows[published.section(group.contract)] += lines
    return common.markdown(HEADER, [line for lines in rows.values() for line in lines])


def main() -> None:
    """Print or write."""
    parser = common.arguments(__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/published-fits.md")
    parser.add_argument("--cache", type=Path, help="folder that keeps integrals")
    given = parser.parse_args()
    text = table(Truth(given.cache), 300 if given.quick else published.POINTS)
    if given.write:
        common.replace_between(published.DOCUMENT, "answers.py", answers=text)
    print(text)


if __name__ == "__main__":
    main()
