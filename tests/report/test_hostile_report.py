"""What users call things reaches a report as text: never as markup, as code or as mathematics."""

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import ecfit
from ecfit.config import StudyConfig
from ecfit.report.style import as_written, rendered
from ecfit.report.write import write_report

MARKUP = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&amp;</style><!--"
MATHS = "$\\frac{$ x_ \\ {{ 7 * 7 }} {% raw %} %s"


class Page(HTMLParser):
    """Elements and attributes of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [name for name, _ in attrs]


@dataclass
class Hostile:
    """The results of a study whose every string is `text`."""

    folder: Path
    text: str
    published: dict[str, Any] = field(default_factory=dict)
    searches: dict[str, Any] = field(default_factory=dict)

    @property
    def config(self) -> StudyConfig:
        data = {"name": "x", "tables": [{"name": "e", "model": "m", "axes": {"mu": 4}}]}
        return StudyConfig.model_validate({**data, "report": {"figures": ["svg"]}})

    @cached_property
    def tables(self) -> dict[str, ecfit.Table]:
        contract = {"model": self.text, "options": {self.text: self.text}, "parameters": {self.text: 1.0}}
        x = np.linspace(0.0, 1.0, 4)
        axes = {self.text: ecfit.Axis.given(self.text, x), "mu": ecfit.Axis.given("mu", x)}
        values = 1.0 - 0.3 * np.outer(x, x)
        return {"e": ecfit.Table.from_array(values, axes, contract, source=self.text)}

    @cached_property
    def fits(self) -> dict[str, list[ecfit.Fit]]:
        made = ecfit.fit(self.tables["e"], ecfit.Polynomial(1))
        named = dataclasses.replace(made.approximation, name=self.text, form=self.text, degree=self.text)
        return {"e": [dataclasses.replace(made, approximation=named)]}

    def warnings(self) -> list[str]:
        return [self.text]


def test_names_are_text_in_a_report(tmp_path: Path):
    study = Hostile(tmp_path, MARKUP + MATHS)
    write_report(study)
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert "<img src=x" not in text
    assert not any(name.startswith("on") for name in page.attributes)
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text  # it is shown
    for path in sorted((tmp_path / "figures").glob("*.svg")):
        drawn = path.read_text(encoding="utf-8")
        assert "<script>alert" not in drawn


def test_dollar_signs_of_names_begin_no_mathematics_and_those_of_ticks_do():
    figure = Figure()
    axes = figure.add_subplot()
    axes.plot([1.0, 2.0], [1e-3, 1e3], label=MATHS)
    axes.set(yscale="log", title=MATHS, xlabel=MATHS, ylabel=MATHS)
    axes.legend()
    drawn = rendered(as_written(figure), "svg").decode()
    assert drawn.count(">$\\frac{$ x") >= 4
    assert ">$\\mathdefault" not in drawn  # 10^2 of the ticks is drawn, not its text
