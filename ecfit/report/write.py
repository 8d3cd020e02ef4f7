"""From a study to its figures, `report.html` (one self-contained page) and `report.md`."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import jinja2
from matplotlib.figure import Figure

from ecfit.approximation import Approximation
from ecfit.config import StudyConfig
from ecfit.files import write_atomically, write_text
from ecfit.fitting import Fit
from ecfit.fitting.selection import Choice as Found
from ecfit.metrics import Errors
from ecfit.report import figures
from ecfit.report.code import Code, codes
from ecfit.report.coefficients import Comparison, compare
from ecfit.report.entries import Entry, best, entries
from ecfit.report.inline import inline, shared
from ecfit.report.maps import Maps, maps
from ecfit.report.slices import slices
from ecfit.report.style import rendered
from ecfit.report.verdict import Proved, Prover, choices, percentage, prover, sentences
from ecfit.tables import Table

# Characters of code, in all languages, that a page has of one approximation at most (some 75 numbers): bigger
# ones are exported from the shell. A report of four tables with 56 fits is below 1 MB.
_CODE_ROOM = 20_000


class StudyLike(Protocol):
    """What a report needs of a study (`ecfit.Study` is one)."""

    @property
    def config(self) -> StudyConfig: ...
    @property
    def folder(self) -> Path: ...
    @property
    def tables(self) -> dict[str, Table]: ...
    @property
    def fits(self) -> dict[str, list[Fit]]: ...
    @property
    def published(self) -> dict[str, list[tuple[Approximation, Errors]]]: ...
    @property
    def searches(self) -> dict[str, list[tuple[str, list[Found]]]]: ...
    def warnings(self) -> list[str]: ...


@dataclass(frozen=True, eq=False)
class _Drawing:
    """A figure to draw: the plain word that names its file, its caption, and its place in the page.

    `page` is "first" (before the slices), "last", or "" for a figure that is in files only, since the page
    says the same in a table or draws it itself.
    """

    stem: str
    caption: str
    draw: Callable[[], Figure]
    page: str


@dataclass(frozen=True)
class _Picture:
    """What a page needs of a drawing; `svg` is empty where it is in files only."""

    stem: str
    caption: str
    svg: str
    first: bool


@dataclass(frozen=True, eq=False)
class _Chosen:
    """A row of the verdict, with what there is to copy."""

    budget: int | None
    allowance: str
    entry: Entry
    proved: Proved
    codes: Sequence[Code]


@dataclass(frozen=True, eq=False)
class _Section:
    """What the report says about one table.

    `choices` are the rows of its verdict, `copied` those whose code is there: the same, and our best fit.
    `shown` is the index of the approximation that the slices begin with.
    """

    name: str
    table: Table
    rows: Sequence[Entry]
    sentences: Sequence[str]
    choices: Sequence[_Chosen]
    copied: Sequence[_Chosen]
    pictures: Sequence[_Picture]
    slices: dict[str, Any]
    shown: int
    maps: Maps | None
    coefficients: Sequence[Comparison]

    @property
    def bounded(self) -> bool:
        """Whether a lower bound of some fit's largest error is known."""
        return any(f.least_max_error is not None for f in self.listed)

    @property
    def listed(self) -> list[Fit]:
        """Our fits."""
        return [e.fit for e in self.rows if e.fit is not None]


def best_fit(fits: Sequence[Fit]) -> Fit | None:
    """The usable fit of the smallest RMSE; where none is usable, the smallest RMSE of all."""
    return min(fits, key=lambda f: (not f.ok, f.rmse), default=None)


def _headline_fits(fits: Sequence[Fit]) -> list[Fit]:
    """The best of each family, and the degree 3 that the literature uses."""
    chosen = []
    for family in dict.fromkeys(f.approximation.form for f in fits):
        members = [f for f in fits if f.approximation.form == family]
        chosen += [f for f in members if f.approximation.degree == "3"]
        best = best_fit(members)
        if best is not None and best not in chosen:
            chosen.append(best)
    return chosen


def _drawings(
    name: str,
    table: Table,
    fits: Sequence[Fit],
    published: Sequence[tuple[Approximation, Errors]],
    rows: Sequence[Entry],
    searches: Sequence[tuple[str, Sequence[Found]]],
) -> Iterator[_Drawing]:
    if searches:
        yield _Drawing(
            f"{name}-searches",
            "The best form of every size that the searches of terms found: RMS error in the weights of "
            "the search, before the fit in the norm asked for, against coefficients (left) and against "
            "operations (right); on the line, nothing found is better for less.",
            lambda: figures.searches(name, searches),
            "first",
        )
    if rows:
        yield _Drawing(
            f"{name}-error-against-cost",
            "RMS error against the numbers to store (left) and the operations of an evaluation (right), both "
            "logarithmic. Lines: fits of this study; stars: published approximations; pluses: fits shipped "
            "with ecfit; triangles: look-up tables, which fetch instead; rings: a pole, or not converged.",
            lambda: figures.error_against_cost(name, rows),
            "first",
        )
    if fits:
        yield _Drawing(
            f"{name}-degree-vs-error",
            "Number of coefficients and mean absolute error by degree (left); mean absolute error "
            "against number of coefficients (right). After Sforza & Pellacini 2022, figure 3.",
            lambda: figures.degree_vs_error(name, table, fits, published),
            "",
        )
    yield _Drawing(
        f"{name}-table",
        "The table and its error estimate." if table.estimated else "The table, as given.",
        lambda: figures.table_and_estimate(name, table),
        "last",
    )
    best_ = best_fit(fits)
    if best_ is None:
        return
    yield _Drawing(
        f"{name}-best-fit",
        f"Table, best fit ({best_.approximation.name}) and signed error.",
        lambda: figures.table_and_fit(name, table, best_),
        "",
    )
    yield _Drawing(
        f"{name}-error-maps",
        "Signed error of every fit; each map has its own scale.",
        lambda: figures.error_maps(name, table, fits),
        "",
    )
    yield _Drawing(
        f"{name}-error-along-axes",
        "Absolute error along each axis: mean (line) and largest (dashes) over the others.",
        lambda: figures.error_along_axes(name, table, _headline_fits(fits), published),
        "last",
    )


def _written(drawing: _Drawing, folder: Path, kinds: Sequence[str], prefix: str) -> _Picture:
    """The picture of a drawing for the page, after its files are written."""
    if not (kinds or drawing.page):
        return _Picture(drawing.stem, drawing.caption, "", False)
    figure = drawing.draw()
    files = {kind: rendered(figure, kind) for kind in kinds}
    for kind, content in files.items():
        path = folder / f"{drawing.stem}.{kind}"
        write_atomically(path, lambda file, content=content: file.write(content))
    svg = ""
    if drawing.page:
        content = files.get("svg") or rendered(figure, "svg")
        svg = inline(content, prefix, drawing.caption)
    return _Picture(drawing.stem, drawing.caption, svg, drawing.page == "first")


def _section(study: StudyLike, number: int, name: str, table: Table, prove: Prover) -> _Section:
    fits, published = study.fits.get(name, []), study.published.get(name, [])
    rows = entries(table, fits, published)
    chosen = [
        _Chosen(c.budget, c.allowance, c.entry, c.proved, _codes(c.entry, name)) for c in choices(rows, prove)
    ]
    named = [c.entry for c in chosen]
    # The best of ours is told in words even where a published one is better within every budget.
    ours = best([e for e in rows if e.kind == "fit"])
    besides = [ours] if ours is not None and ours not in named else []
    spare = [_Chosen(None, "", e, prove(e.approximation), _codes(e, name)) for e in besides]
    drawn = list(dict.fromkeys([*besides, *named, *(e for e in rows if e.kind in ("published", "shipped"))]))
    drawings = _drawings(name, table, fits, published, rows, study.searches.get(name, []))
    folder, kinds = study.folder / "figures", study.config.report.figures
    return _Section(
        name,
        table,
        rows,
        sentences(rows),
        chosen,
        [*chosen, *spare],
        [_written(d, folder, kinds, f"s{number}f{i}-") for i, d in enumerate(drawings)],
        slices(table, drawn),
        drawn.index(ours) if ours is not None else 0,
        maps(table, rows),
        [c for approximation, _ in published for c in compare(approximation, fits)],
    )


def _with_shared_styles(sections: Sequence[_Section]) -> tuple[list[_Section], str]:
    """The sections with figures whose styles are classes, and the sheet that defines these."""
    svgs, sheet = shared([picture.svg for section in sections for picture in section.pictures if picture.svg])
    left = iter(svgs)
    out = [
        replace(s, pictures=[replace(p, svg=next(left)) if p.svg else p for p in s.pictures])
        for s in sections
    ]
    return out, sheet


def _codes(entry: Entry, table: str) -> list[Code]:
    found = codes(entry, table)
    return found if sum(len(c.text) for c in found) <= _CODE_ROOM else []


def write_report(study: StudyLike) -> None:
    """Write `figures/*`, `report.html` and `report.md` into the study's folder."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ecfit.report", "templates"),
        autoescape=lambda name: bool(name) and name.endswith(".html"),  # pyright: ignore
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    prove = prover(study.folder)
    sections = [_section(study, i, name, t, prove) for i, (name, t) in enumerate(study.tables.items())]
    rows = [row for section in sections for row in section.rows]
    ours = sum(row.kind == "fit" for row in rows)
    sections, styles = _with_shared_styles(sections)
    kind = study.config.report.figures[0] if study.config.report.figures else None
    context = {
        "study": study,
        "sections": sections,
        "counts": {"fits": ours, "others": len(rows) - ours},
        "warnings": study.warnings(),
        "image": kind,
        "infinity": float("inf"),
        "percentage": percentage,
        "css": environment.get_template("report.css").render() + styles,
        "js": environment.get_template("report.js").render(),
    }
    for page in ("report.html", "report.md"):
        write_text(study.folder / page, environment.get_template(page).render(**context))
