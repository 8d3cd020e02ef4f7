"""The figures and tables of docs/choosing-a-fit.md: error against numbers stored and against time.

    python benchmarks/choosing.py --cache .choosing --write     # some 20 minutes the first time
    python benchmarks/choosing.py --points 1000 --quick         # a look, on the screen; figures in a folder

For every quantity that a shipped fit approximates: all shipped fits of it, published formulas of the same
quantity, and tables of 16, 32 and 64 nodes an axis in two spacings. Errors are against the model, integrated
to 1e-8 at the sample of `ecfit certify` (random points off any grid); times are those of
benchmarks/evaluation.py. Integrals are kept in the folder --cache: a new fit needs none.
"""

import hashlib
import itertools
import json
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import common
import evaluation
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

import ecfit
from ecfit.approximation import Approximation, lookup_table, published_names
from ecfit.approximation.shipped import shipped_folder
from ecfit.certify.truth import LOOSE, Sampling
from ecfit.contract import Contract
from ecfit.coordinates import resolve
from ecfit.errors import EcfitError
from ecfit.expressions import cost
from ecfit.files import read_json
from ecfit.report.style import look, rendered
from ecfit.tables.scattered import Scattered, integrate, of_contract
from ecfit.tables.tabulate import NUMERICS_VERSION

Array = np.ndarray
Points = dict[str, Array]

TOLERANCE, TABLE_TOLERANCE = 1e-8, 1e-7
# Mean errors that a reader may ask for.
BUDGETS = (1e-2, 1e-3, 1e-4)
OURS, PUBLISHED, TABLES = "#D55E00", "#000000", ("#009E73", "#0072B2")
# Maps of the second spacing of tables, coordinate = map(t), by how many roots of the coordinate give t.
_MAPS = ("identity", "square", "fourth-power")
# Options that titles do not mention.
_USUAL = {"ndf": "ggx", "base": "none", "compensation": "none"}
# Materials in the order of the document; others follow.
_ORDER = (
    ("conductor", "directional-albedo"),
    ("glossy", "directional-albedo"),
    ("dielectric", "directional-albedo"),
    ("conductor", "schlick-b"),
    ("conductor", "schlick-a"),
    ("conductor", "average-albedo"),
    ("dielectric", "average-fresnel"),
)


@dataclass(frozen=True, eq=False)
class Entry:
    """One way to get the number, and how well it does.

    Attributes:
        name: as `ecfit list` has it, or the table's; label: for figures.
        kind: "ours", "published", "table" or "curved table".
        numbers, operations, ns: what it costs; ns is NaN where nothing was measured.
        mae, largest: errors; points: the part of the sample that is in its domain.
        note: in what it differs from the quantity of the figure.
        domain: in words, of a fit that reaches further than the sample.
        certified: whether it carries a certificate.
    """

    name: str
    label: str
    kind: str
    numbers: int
    operations: str
    total: float
    ns: float
    mae: float
    largest: float
    points: float = 1.0
    note: str = ""
    domain: str = ""
    certified: bool = False


@dataclass(eq=False)
class Material:
    """One quantity: its contract, the shipped fits of it, and the sample over their common domain."""

    contract: Contract
    fits: list[Approximation]
    entries: list[Entry] = field(default_factory=list)

    @property
    def variables(self) -> tuple[str, ...]:
        return self.fits[0].variables

    @property
    def domain(self) -> tuple[tuple[float, float], ...]:
        """What all shipped fits have in common."""
        ends = [domain_in(f, self.variables) for f in self.fits]
        return tuple((max(e[v][0] for e in ends), min(e[v][1] for e in ends)) for v in self.variables)

    @property
    def title(self) -> str:
        return title(self.contract)

    @property
    def slug(self) -> str:
        return "".join(c if c.isalnum() else "-" for c in self.title.lower()).replace("--", "-").strip("-")

    def points(self, count: int) -> Points:
        return Sampling(count).points(replace(self.fits[0], domain=self.domain))


def title(contract: Contract) -> str:
    """The quantity in a few words: what is usual is left out."""
    options = contract.options
    what = {
        "directional-albedo": "",
        "average-albedo": ", average",
        "average-fresnel": ", average Fresnel",
        "schlick-a": ", Schlick A",
        "schlick-b": ", Schlick B",
    }.get(contract.quantity, f", {contract.quantity}")
    words = [contract.model.capitalize(), options.get("side", "")]
    if contract.model == "conductor" or options.get("masking") == "height-correlated":
        words.append(options.get("masking", ""))
    words += [options[name] for name, usual in _USUAL.items() if options.get(name, usual) != usual]
    words += [f"{name} {value:g}" for name, value in sorted(contract.parameters.items())]
    words += [contract.transport] if contract.transport != "energy" else []
    words += [contract.lobe] if contract.lobe != "all" else []
    return " ".join(filter(None, words)) + what


def domain_in(approximation: Approximation, variables: Sequence[str]) -> dict[str, tuple[float, float]]:
    """The domain in other views of the same coordinates (r for alpha, ior for F0)."""
    own = dict(zip(approximation.variables, approximation.domain, strict=True))
    low, high = (resolve(variables, {n: np.float64(e[i]) for n, e in own.items()}) for i in (0, 1))
    return {v: (float(low[v]), float(high[v])) for v in variables}


def materials() -> list[Material]:
    """The shipped fits, those of one quantity together."""
    found: dict[str, Material] = {}
    for name in ecfit.shipped():
        fit = ecfit.shipped(name)
        key = json.dumps(fit.contract.to_dict(), sort_keys=True)
        found.setdefault(key, Material(fit.contract, [])).fits.append(fit)
    for material in found.values():
        material.fits.sort(key=lambda f: f.count)

    def place(material: Material) -> tuple[int, str]:
        key = material.contract.model, material.contract.quantity
        options = material.contract.options
        # Separable before height-correlated, entering before leaving.
        rank = f"{options.get('side', '')} {options.get('masking') == 'height-correlated'}"
        return _ORDER.index(key) if key in _ORDER else len(_ORDER), rank

    return sorted(found.values(), key=place)


def differences(published: Contract, ours: Contract) -> list[str] | None:
    """In what a published formula's quantity differs in options or transport; None: not comparable."""
    for name in ("model", "quantity", "lobe"):
        if getattr(published, name) != getattr(ours, name):
            return None
    if dict(published.parameters) != dict(ours.parameters):
        return None
    if dict(published.quantity_options) != dict(ours.quantity_options):
        return None
    if published.options.get("side") != ours.options.get("side"):
        return None
    if published.options.get("compensation") != ours.options.get("compensation"):
        return None
    return published.differences(ours)


def roots(name: str, ends: Mapping[str, tuple[float, float]]) -> int:
    """How often to take the root of a coordinate for nodes that are denser where the albedo changes fast."""
    if name == "F0":
        return 2 if ends["F0"][1] < 0.5 else 1
    return 1 if name == "mu" else 0


class Truth:
    """Integrals, kept in a folder: what took long is not computed twice."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    def _kept(self, key: dict, make, names: Sequence[str]) -> tuple[Array, ...]:
        text = json.dumps({**key, "numerics": NUMERICS_VERSION}, sort_keys=True)
        path = None
        if self.folder is not None:
            path = self.folder / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.npz"
            if path.exists():
                with np.load(path) as data:
                    return tuple(data[n] for n in names)
        made = make()
        if path is not None:
            np.savez(path, **dict(zip(names, made, strict=True)))
        return made

    def at(self, contract: Contract, points: Points) -> Scattered:
        """The quantity at the points."""
        settings = replace(contract, sampling="true").to_dict()
        digest = hashlib.sha256(b"".join(p.tobytes() for p in points.values())).hexdigest()
        key = {"truth": settings, "points": [*points, digest], "tolerance": TOLERANCE}
        made = self._kept(key, lambda: integrate(contract, points, TOLERANCE), Scattered._fields)
        return Scattered(*made)

    def table(self, material: Material, count: int, curved: bool) -> Approximation:
        """A table of the material's quantity over the sample's domain."""
        contract = material.contract
        bsdf, _ = of_contract(contract)
        # Nodes in r, as renderers have them, not in alpha; F0 or ior as the fits have it.
        names = ["r" if v == "alpha" else v for v in reversed(material.variables)]
        ends = dict(zip(material.variables, material.domain, strict=True))
        kept = {n: ends[n] for n in names if n in ends and n != "mu"}
        through = {n: _MAPS[k] for n in names if (k := roots(n, ends) if curved else 0)}

        def make() -> Approximation:
            return lookup_table(
                bsdf,
                dict.fromkeys(names, count),
                through=through,
                ranges=kept,
                quantity=contract.quantity,
                lobe=contract.lobe,
                transport=contract.transport,
                tolerance=TABLE_TOLERANCE,
                quantity_options={k: int(v) for k, v in contract.quantity_options.items()},
            )

        key = {"table": contract.to_dict(), "names": names, "count": count, "through": through, "ends": kept}
        (text,) = self._kept(key, lambda: (np.array(json.dumps(make().to_dict())),), ["approximation"])
        return Approximation.from_dict(json.loads(str(text)))


def errors(approximation: Approximation, points: Points, truth: Scattered) -> tuple[float, float, float]:
    """MAE, largest error, and the part of the sample within the approximation's domain."""
    at = resolve(approximation.variables, points)
    usable = np.isfinite(truth.values) & (truth.errors <= LOOSE)
    inside = usable.copy()
    for name, (low, high) in zip(approximation.variables, approximation.domain, strict=True):
        # The ends of a domain may have been rounded on the way through another view.
        slack = 1e-9 * (high - low)
        inside &= (at[name] >= low - slack) & (at[name] <= high + slack)
    if not inside.any():
        raise EcfitError(f"{approximation.name}: no point of the sample lies in its domain")
    found = approximation.formula.value([np.asarray(at[n])[inside] for n in approximation.variables])
    e = np.abs(np.asarray(found) - truth.values[inside])
    return float(e.mean()), float(e.max()), float(inside.sum() / usable.sum())


def certified(name: str) -> bool:
    """Whether a shipped fit's certificate was granted."""
    certificate = read_json(shipped_folder() / f"{name}.json").get("certificate")
    return isinstance(certificate, Mapping) and bool(certificate.get("certified"))


def beyond(fit: Approximation, material: Material) -> str:
    """The domain of a fit where it is larger than what the material's fits have in common."""
    own = domain_in(fit, material.variables)
    wider = [
        f"{name} in [{own[name][0]:.3g}, {own[name][1]:.3g}]"
        for name, common_ in zip(material.variables, material.domain, strict=True)
        if not np.allclose(own[name], common_, rtol=1e-6, atol=1e-9)
    ]
    return f"also for {', '.join(wider)}" if wider else ""


def competitors(material: Material) -> list[tuple[Approximation, list[str]]]:
    """Published formulas of the quantity; where there are none, those that differ in a convention."""
    same, near = [], []
    for name in published_names():
        published = ecfit.published(name)
        differing = differences(published.contract, material.contract)
        try:
            domain_in(published, material.variables)
        except EcfitError:  # of other coordinates
            continue
        if differing is not None:
            (near if differing else same).append((published, differing))
    return same or near


def author(approximation: Approximation) -> str:
    """Who published it and when, for figures: "Kulla & Conty 2017"."""
    source = approximation.source
    name = re.split(r",| \(", source)[0]
    year = re.search(r"\b(19|20)\d\d", source)
    return name if year is None or year[0] in name else f"{name} {year[0]}"


def fill(
    material: Material, truths: Truth, count: int, times: Mapping[str, float], sizes: Sequence[int]
) -> None:
    """Measure all ways to get the quantity of a material."""
    points = material.points(count)
    truth = truths.at(material.contract, points)
    nan = float("nan")
    for fit in material.fits:
        operations = cost(fit.expression())
        material.entries.append(
            Entry(
                fit.name, str(fit.count), "ours", fit.count, str(operations), operations.total,
                times.get(fit.name, nan), *errors(fit, points, truth), domain=beyond(fit, material),
                certified=certified(fit.name),
            )
        )  # fmt: skip
    for published, differing in competitors(material):
        against = truths.at(published.contract, points) if differing else truth
        operations = cost(published.expression())
        material.entries.append(
            Entry(
                published.name, author(published), "published", published.count, str(operations),
                operations.total, times.get(published.name, nan), *errors(published, points, against),
                note=", ".join(differing),
            )
        )  # fmt: skip
    ends = dict(zip(material.variables, material.domain, strict=True))
    for curved in (False, True) if any(roots(v, ends) for v in ends) else (False,):
        for nodes in sizes:
            table = truths.table(material, nodes, curved)
            taken = tuple(roots(n, ends) if curved else 0 for n in table.variables)
            size = f"{nodes}" + (f"^{len(taken)}" if len(taken) > 1 else "")
            how = "".join(f", {n} = t^{2**k}" for n, k in zip(table.variables, taken, strict=True) if k)
            material.entries.append(
                Entry(
                    f"table {size}{how}", size,
                    "curved table" if curved else "table", table.count, "", nan,
                    times.get(evaluation.table_name(nodes, taken), nan), *errors(table, points, truth),
                )
            )  # fmt: skip


# --- Figures.

# Kinds whose points a line joins, and its colour.
_LINES = {"ours": OURS, "table": TABLES[0], "curved table": TABLES[1]}


class Labels:
    """Places labels beside their points where they hide neither points nor each other."""

    def __init__(self, figure: Figure, axes: Axes) -> None:
        self.axes = axes
        self.renderer = FigureCanvasAgg(figure).get_renderer()
        self.taken: list[Bbox] = []
        self.lines: list[Bbox] = []
        self.frame = axes.get_window_extent(self.renderer)

    def keep_clear(self, x: float, y: float) -> None:
        px, py = self.axes.transData.transform((x, y))
        self.taken.append(Bbox.from_extents(px - 5.0, py - 5.0, px + 5.0, py + 5.0))

    def keep_line_clear(self, x: Sequence[float], y: Sequence[float]) -> None:
        """A label may cross a line rather than cover a point."""
        ends = self.axes.transData.transform(np.column_stack([x, y])) if len(x) else np.zeros((0, 2))
        for a, b in itertools.pairwise(ends):
            for px, py in np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / 4.0))):
                self.lines.append(Bbox.from_extents(px - 1.0, py - 1.0, px + 1.0, py + 1.0))

    def place(
        self, x: float, y: float, text: str, colour: str, size: float = 7.0, bold: bool = False
    ) -> None:
        """Write at the first free place of several around the point, nearest first."""
        note = self.axes.annotate(
            text, (x, y), xytext=(0, 0), textcoords="offset points", fontsize=size, color=colour,
            weight="bold" if bold else "normal", va="center",
        )  # fmt: skip
        best: tuple[float, tuple[float, float], str, Bbox] | None = None
        for distance in (7.0, 11.0, 16.0, 23.0, 32.0, 43.0, 56.0):
            for dx, dy in (
                (1, 0),
                (0.8, 0.7),
                (0.8, -0.7),
                (0, 1),
                (0, -1),
                (-0.8, 0.7),
                (-0.8, -0.7),
                (-1, 0),
            ):
                align = "left" if dx > 0 else "right" if dx < 0 else "center"
                note.set_horizontalalignment(align)
                note.set_position((dx * distance, dy * distance))
                box = note.get_window_extent(self.renderer).padded(2.5)
                inside = (
                    box.x0 >= self.frame.x0 and box.x1 <= self.frame.x1 + 4.0
                    and box.y0 >= self.frame.y0 and box.y1 <= self.frame.y1 + 4.0
                )  # fmt: skip
                hits = float(sum(box.overlaps(other) for other in self.taken))
                hits += 0.1 * any(box.overlaps(other) for other in self.lines)
                score = hits + 0.004 * distance + (0.0 if inside else 10.0)
                if best is None or score < best[0]:
                    best = score, (dx * distance, dy * distance), align, box
        assert best is not None
        _, offset, align, box = best
        note.set_horizontalalignment(align)
        note.set_position(offset)
        self.taken.append(box)
        if max(map(abs, offset)) > 14.0:
            # A thin line says which point a distant label belongs to.
            self.axes.annotate(
                "", (x, y), xytext=offset, textcoords="offset points",
                arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.4, "shrinkA": 0, "shrinkB": 3},
            )  # fmt: skip


def of_kind(entries: Sequence[Entry], kind: str) -> list[Entry]:
    """Those of one kind, of few numbers first."""
    return sorted((e for e in entries if e.kind == kind), key=lambda e: e.numbers)


def figure_of(material: Material, timed: bool) -> Figure:
    """MAE and largest error, against numbers stored and against time (or operations)."""
    entries = [e for e in material.entries if np.isfinite(e.mae) and e.mae > 0.0]

    def time_of(e: Entry) -> float:
        return e.ns if timed else e.total

    rows = (
        (lambda e: float(e.numbers), "numbers stored"),
        (time_of, "ns an evaluation, float32 in C" if timed else "operations, in multiply-adds"),
    )
    columns = ((lambda e: e.mae, "mean absolute error"), (lambda e: e.largest, "largest error"))
    with look():
        figure = Figure(figsize=(9.6, 7.4), layout="constrained")
        panels = figure.subplots(2, 2, sharey="col")
        drawn = []
        for (of_x, x_label), panel_row in zip(rows, panels, strict=True):
            for (of_y, y_label), axes in zip(columns, panel_row, strict=True):
                shown = [e for e in entries if np.isfinite(of_x(e)) and np.isfinite(of_y(e))]
                for e in shown:
                    x, y = of_x(e), of_y(e)
                    if e.kind == "ours":
                        axes.plot(x, y, "o", color=OURS, markersize=6, zorder=3)
                    elif e.kind == "published":
                        face = "none" if e.note else PUBLISHED
                        axes.plot(x, y, "^", color=PUBLISHED, markersize=5.5, markerfacecolor=face)
                    else:
                        axes.plot(x, y, "s", color=TABLES[e.kind == "curved table"], markersize=4.5)
                for kind, colour in _LINES.items():
                    line = of_kind(shown, kind)
                    axes.plot(
                        [of_x(e) for e in line],
                        [of_y(e) for e in line],
                        color=colour,
                        linewidth=0.8,
                        alpha=0.6,
                    )
                axes.set(xscale="log", yscale="log", xlabel=x_label, ylabel=f"{y_label} (albedo, no unit)")
                axes.margins(0.16, 0.1)
                axes.grid(True, which="major", alpha=0.25, linewidth=0.5)
                axes.minorticks_off()
                _plain_ticks(axes)
                drawn.append((axes, of_x, of_y, shown))
        hollow = (
            " (hollow: another convention, judged by its own integral)"
            if any(e.note for e in entries)
            else ""
        )
        figure.suptitle(material.title + hollow, fontsize=10)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        for axes, of_x, of_y, shown in drawn:
            labels = Labels(figure, axes)
            for e in shown:
                labels.keep_clear(of_x(e), of_y(e))
            for kind in _LINES:
                line = of_kind(shown, kind)
                labels.keep_line_clear([of_x(e) for e in line], [of_y(e) for e in line])
            for e in sorted(shown, key=lambda e: e.kind != "ours"):
                colour = _LINES.get(e.kind, PUBLISHED)
                labels.place(of_x(e), of_y(e), _label(e, shown), colour, bold=e.kind == "ours")
    return figure


def svg(figure: Figure) -> bytes:
    """A figure as an SVG of less weight: coordinates to 0.01 point, one family of fonts."""
    text = rendered(figure, "svg").decode()
    text = re.sub(r"(\d+\.\d{2})\d+", r"\1", text)
    text = re.sub(r' transform="rotate\(-0 [^"]*"', "", text)
    text = re.sub(
        r"font-family: 'DejaVu Sans',[^;\"]*", "font-family: 'DejaVu Sans', Verdana, sans-serif", text
    )
    return re.sub(r"\n\s+", "\n", text).encode()


def _label(e: Entry, shown: Sequence[Entry]) -> str:
    """A name; of the tables on a line, the largest says how its nodes are spaced."""
    if e.kind == "ours":
        return e.name
    if e.kind == "published":
        return e.label + (
            f" ({e.note.replace('transport = ', '').replace('masking = ', '')})" if e.note else ""
        )
    plain = ", uniform" if e.kind == "table" else ""
    text = f"{e.name}{plain}" if e is of_kind(shown, e.kind)[-1] else e.label
    text = text.replace("table ", "").replace("^2", "²").replace("^3", "³").replace("^4", "⁴")
    return text


def _plain_ticks(axes: Axes) -> None:
    """Ticks at decades, and between them where few decades are shown."""
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        ratio = high / low
        steps = (1, 2, 3, 4, 5, 6, 8) if ratio < 8.0 else (1, 2, 5) if ratio < 300.0 else (1,)
        ticks = [(s, k) for k in range(-8, 8) for s in steps if low <= s * 10.0**k <= high]
        axis.set_ticks([s * 10.0**k for s, k in ticks], [_tick(s, k) for s, k in ticks])


def _tick(step: int, power: int) -> str:
    if power >= -2:
        return f"{step * 10.0**power:,.10g}"
    raised = str(-power).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"10⁻{raised}" if step == 1 else f"{step}·10⁻{raised}"


# --- Tables.


def number(value: float) -> str:
    """An error or a time for readers."""
    return f"{value:.2g}" if value >= 0.01 else f"{value:.1e}"


def nanoseconds(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else ""


def details(material: Material) -> str:
    """All entries of a material, those of few numbers first."""
    rows = []
    for e in sorted(material.entries, key=lambda e: (e.kind != "ours", e.kind != "published", e.numbers)):
        notes = [e.note] if e.note else []
        if e.points < 0.995:
            notes.append(f"at the {e.points:.0%} of the points in its domain")
        if e.kind == "ours":
            notes.append("certified" if e.certified else "not certified")
            notes += [e.domain] if e.domain else []
        name = f"`{e.name}`" if e.kind in ("ours", "published") else e.name
        rows.append(
            [name, str(e.numbers), nanoseconds(e.ns), number(e.mae), number(e.largest), ", ".join(notes)]
        )
    return common.markdown(["", "numbers", "ns", "mean error", "largest error", "notes"], rows)


def iors(material: Material) -> str:
    """The range of ior, where F0 is a coordinate."""
    ends = dict(zip(material.variables, material.domain, strict=True)).get("F0")
    if ends is None:
        return ""
    ior = resolve(["ior"], {"F0": np.array(ends)})["ior"]
    return f"ior in [{ior[0]:.4g}, {ior[1]:.4g}]"


def ranges(material: Material) -> str:
    """The domain in words, F0 with its ior."""
    parts = []
    for name, (low, high) in zip(material.variables, material.domain, strict=True):
        text = f"{name} in [{low:.4g}, {high:.4g}]"
        parts.append(f"{text} ({iors(material)})" if name == "F0" else text)
    return ", ".join(parts)


def chosen(material: Material) -> list[tuple[str, Entry]]:
    """For each bound of the error the certified fit of fewest numbers, then the most accurate; each once."""
    ours = [e for e in material.entries if e.kind == "ours" and e.certified]
    merged: dict[str, tuple[str, Entry]] = {}
    for budget in BUDGETS:
        enough = [e for e in ours if e.mae <= budget]
        if enough:
            least = min(enough, key=lambda e: e.numbers)
            merged[least.name] = f"mean error below {budget:g}", least
    if ours:
        best = min(ours, key=lambda e: e.mae)
        wish = f"{merged[best.name][0]}; " if best.name in merged else ""
        merged[best.name] = f"{wish}the least mean error", best
    return list(merged.values())


def recommendations(found: Sequence[Material]) -> str:
    """One row for each material and wish."""
    rows = []
    for material in found:
        tables = [e for e in material.entries if "table" in e.kind]
        for i, (wish, e) in enumerate(chosen(material)):
            as_good = [t for t in tables if t.mae <= e.mae and t.largest <= e.largest]
            equal = min(as_good, key=lambda t: t.numbers, default=None)
            text = "none of those measured"
            if equal is not None:
                text = f"{equal.name.removeprefix('table ')}: {equal.numbers:,} numbers"
                text += f", {nanoseconds(equal.ns)} ns" if np.isfinite(equal.ns) else ""
            rows.append(
                [
                    ", ".join(filter(None, (material.title, iors(material)))) if i == 0 else "",
                    wish,
                    f"`{e.name}`",
                    str(e.numbers),
                    nanoseconds(e.ns),
                    number(e.mae),
                    number(e.largest),
                    text,
                ]
            )
    header = [
        "material",
        "you want",
        "use",
        "numbers",
        "ns",
        "mean error",
        "largest error",
        "a table as good",
    ]
    return common.markdown(header, rows)


def sections(found: Sequence[Material], count: int) -> str:
    """A section a material: its figure and all that was measured."""
    parts = []
    for m in found:
        parts += [
            f"### {m.title}",
            f"Over {ranges(m)}; {count:,} random points, r from 0.03 and mu from 0.02.",
            f"![{m.title}: error against numbers stored and against time](figures/choosing-{m.slug}.svg)",
            details(m),
        ]
    return "\n\n".join(parts)


def main() -> None:
    parser = common.arguments(__doc__)
    parser.add_argument("--points", type=int, default=20_000, help="points of the sample (20000)")
    parser.add_argument("--cache", type=Path, help="folder that keeps integrals and tables")
    parser.add_argument("--figures", type=Path, help="folder of the figures (docs/figures with --write)")
    parser.add_argument("--only", help="materials whose title has this in it")
    parser.add_argument(
        "--write", action="store_true", help="write docs/choosing-a-fit.md, its figures and times"
    )
    given = parser.parse_args()
    found = [m for m in materials() if given.only is None or given.only.lower() in m.title.lower()]
    if given.write and (given.only or given.quick or given.points < 20_000):
        parser.error(
            "--write needs all materials and the whole sample: leave out --only, --quick and --points"
        )
    times: dict[str, float] = {}
    measured: list[evaluation.Timed] = []
    try:
        measured = evaluation.measure(evaluation.formulas(), given.quick)
        times = {t.name: t.native for t in measured}
    except EcfitError as error:
        if evaluation.compiler() is not None:
            raise
        print(f"{error}; costs in operations instead", file=sys.stderr)
    truths = Truth(given.cache)
    folder = given.figures or (common.DOCS / "figures" if given.write else Path("choosing-figures"))
    folder.mkdir(parents=True, exist_ok=True)
    for material in found:
        fill(material, truths, given.points, times, evaluation.TABLES[: 2 if given.quick else None])
        (folder / f"choosing-{material.slug}.svg").write_bytes(svg(figure_of(material, bool(times))))
        print(f"\n{material.title}\n\n{details(material)}", flush=True)
    advice = recommendations(found)
    print(f"\n{advice}")
    if given.write:
        generated = {"recommendations": advice, "materials": sections(found, given.points)}
        common.replace_between(common.DOCS / "choosing-a-fit.md", "choosing.py", **generated)
        if measured:  # both documents show the times of one run
            table = evaluation.printed(measured)
            common.replace_between(common.DOCS / "performance.md", "evaluation.py", evaluation=table)


if __name__ == "__main__":
    main()
