"""From a study to its figures, `report.html` (one self-contained page) and `report.md`."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import jinja2
import numpy as np
from matplotlib.figure import Figure

from ecfit.approximation import Approximation
from ecfit.config import StudyConfig
from ecfit.files import write_atomically, write_text
from ecfit.fitting import Fit
from ecfit.fitting.selection import Choice
from ecfit.metrics import Errors
from ecfit.report import figures
from ecfit.report.coefficients import Comparison, compare
from ecfit.report.style import as_written, rendered
from ecfit.tables import Table


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
    def searches(self) -> dict[str, list[tuple[str, list[Choice]]]]: ...
    def warnings(self) -> list[str]: ...


@dataclass(frozen=True)
class _Picture:
    """A figure, the plain word that names its file, and its caption."""

    stem: str
    caption: str
    figure: Figure


@dataclass(frozen=True)
class _Section:
    """What the report says about one table."""

    name: str
    table: Table
    fits: Sequence[Fit]
    published: Sequence[tuple[Approximation, Errors]]
    verdict: str
    pictures: Sequence[_Picture]
    svg: Sequence[str]
    coefficients: Sequence[Comparison]

    @property
    def bounded(self) -> bool:
        """Whether a lower bound of some fit's largest error is known."""
        return any(f.least_max_error is not None for f in self.fits)


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


def _pictures(
    name: str,
    table: Table,
    fits: Sequence[Fit],
    published: Sequence[tuple[Approximation, Errors]],
    searches: Sequence[tuple[str, Sequence[Choice]]],
) -> list[_Picture]:
    out = []
    if searches:
        out.append(
            _Picture(
                f"{name}-searches",
                "The best form of every size that the searches of terms found: RMS error in the weights of "
                "the search, before the fit in the norm asked for, against coefficients (left) and against "
                "operations (right); on the line, nothing found is better for less.",
                figures.error_against_cost(name, searches),
            )
        )
    if fits:
        out.append(
            _Picture(
                f"{name}-degree-vs-error",
                "Number of coefficients and mean absolute error by degree (left); mean absolute error "
                "against number of coefficients (right). After Sforza & Pellacini 2022, figure 3.",
                figures.degree_vs_error(name, table, fits, published),
            )
        )
    out.append(
        _Picture(
            f"{name}-table",
            "The table and its error estimate." if table.estimated else "The table, as given.",
            figures.table_and_estimate(name, table),
        )
    )
    best = best_fit(fits)
    if best is not None:
        headline = _headline_fits(fits)
        out += [
            _Picture(
                f"{name}-best-fit",
                f"Table, best fit ({best.approximation.name}) and signed error.",
                figures.table_and_fit(name, table, best),
            ),
            _Picture(
                f"{name}-error-maps",
                "Signed error of every fit; each map has its own scale.",
                figures.error_maps(name, table, fits),
            ),
            _Picture(
                f"{name}-error-along-axes",
                "Absolute error along each axis: mean (line) and largest (dashes) over the others.",
                figures.error_along_axes(name, table, headline, published),
            ),
        ]
    return out


def _verdict(fits: Sequence[Fit]) -> str:
    best = best_fit(fits)
    if best is None:
        return "No fits were asked for."
    if not best.ok:
        return f"No usable fit: {best.warning()}."
    verdict = (
        f"Best fit: {best.approximation.name}, {best.approximation.count} coefficients: MAE {best.mae:.2e}, "
        f"RMSE {best.rmse:.2e}, largest error {best.max_error:.2e}"
    )
    if not np.isfinite(best.errors.furnace_max):
        return verdict + "."  # the table or the fit reaches 0: no normaliser
    return (
        f"{verdict}; a white furnace normalised with it deviates by "
        f"{100 * best.errors.furnace_mean:.2g} % on average and "
        f"{100 * best.errors.furnace_max:.2g} % at worst."
    )


def _inline(svg: bytes, prefix: str) -> str:
    """An SVG for a page that holds several: no XML header, and ids that do not clash."""
    text = svg.decode("utf-8")
    text = text[text.index("<svg") :]
    # Hundredths of a point are not seen, but weigh a third of the page.
    text = re.sub(r"(\d\.\d\d)\d+", r"\1", text)
    text = re.sub(r">\s+<", "><", text)
    used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{prefix}{m[1]}"' if m[1] in used else "", text)
    return re.sub(r'(url\(#|href="#)', lambda m: m[1] + prefix, text)


def write_report(study: StudyLike) -> None:
    """Write `figures/*`, `report.html` and `report.md` into the study's folder."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ecfit.report", "templates"),
        autoescape=lambda name: bool(name) and name.endswith(".html"),  # pyright: ignore
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    sections = []
    for name, table in study.tables.items():
        fits, published = study.fits.get(name, []), study.published.get(name, [])
        pictures = _pictures(name, table, fits, published, study.searches.get(name, []))
        svg = []
        for picture in pictures:
            bytes_ = rendered(as_written(picture.figure), "svg")
            svg.append(_inline(bytes_, f"{picture.stem}-"))
            for kind in study.config.report.figures:
                content = bytes_ if kind == "svg" else rendered(picture.figure, kind)
                path = study.folder / "figures" / f"{picture.stem}.{kind}"
                write_atomically(path, lambda file, content=content: file.write(content))
        coefficients = [c for approximation, _ in published for c in compare(approximation, fits)]
        sections.append(_Section(name, table, fits, published, _verdict(fits), pictures, svg, coefficients))
    kind = study.config.report.figures[0] if study.config.report.figures else None
    context = {"study": study, "sections": sections, "warnings": study.warnings(), "image": kind}
    for page in ("report.html", "report.md"):
        write_text(study.folder / page, environment.get_template(page).render(**context))
