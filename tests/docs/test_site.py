"""The site: built strictly, loading nothing from the network, with every page and every public name in it."""

import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import ecfit

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
needs_mkdocs = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("mkdocs", "material", "mkdocstrings")),
    reason="no MkDocs: pip install 'ecfit[docs]'",
)


class Loads(HTMLParser):
    """What a page loads by itself (scripts, styles, images, frames), and the files that its links lead to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Sort by tag: a link to a page is followed by people only."""
        said = {key: value or "" for key, value in attributes}
        if tag == "a":
            self.links.append(said.get("href", ""))
        elif tag != "link" or said.get("rel") in ("stylesheet", "icon", "preload", "preconnect"):
            self.loads += [said[key] for key in ("src", "href", "srcset", "data") if said.get(key)]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site as `make docs` builds it: a warning is an error."""
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    return folder


def pages(site: Path) -> Iterator[tuple[Path, Loads]]:
    """The pages of a site, but for copies of studies' own HTML."""
    for path in sorted(site.rglob("*.html")):
        yield path, Loads(path.read_text())


def named() -> list[tuple[str, str]]:
    """What the pages of the reference show: (where it is, what it is called if otherwise)."""
    text = "\n".join(path.read_text() for path in (DOCS / "api").glob("*.md"))
    return re.findall(r"^::: (\S+)(?:\n    options: \{ heading: (\S+) \})?$", text, re.MULTILINE)


@pytest.mark.slow
@needs_mkdocs
def test_pages_load_nothing_from_the_network(site: Path):
    found = [(path.name, url) for path, page in pages(site) for url in page.loads if urlsplit(url).netloc]
    assert found == []
    styles = [
        (p.name, m) for p in site.rglob("*.css") for m in re.findall(r"url\(.?https?:[^)]*", p.read_text())
    ]
    assert styles == []
    assert sum(len(page.loads) for _, page in pages(site)) > 100


@pytest.mark.slow
@needs_mkdocs
def test_what_pages_load_and_link_to_is_there(site: Path):
    missing = [
        (path.name, url)
        for path, page in pages(site)
        for url in page.loads + page.links
        if (name := urlsplit(url).path)
        and not urlsplit(url).scheme
        and path.name != "404.html"
        and not (path.parent / name).exists()
    ]
    assert missing == []


@pytest.mark.slow
@needs_mkdocs
def test_the_reference_shows_functions_and_classes_with_their_text(site: Path):
    text = "".join(path.read_text() for path in (site / "api").glob("*.html"))
    assert "doc-symbol-module" not in text  # a module of a function's name, in its place
    headings = re.findall(r'<h2 id="(\S+)" class="doc doc-heading">', text)
    assert set(headings) == {path for path, _ in named()}
    assert "Integrate a quantity of a model on a grid." in text
    assert "--workers" in (site / "api" / "commands.html").read_text()


def test_every_public_name_is_in_the_reference_once():
    shown = [heading or path for path, heading in named()]
    assert len(shown) == len(set(shown))
    assert {f"ecfit.{name}" for name in ecfit.__all__ if name != "__version__"} <= set(shown)


def test_every_page_has_its_place_in_the_navigation():
    entries = set(re.findall(r"[\w/-]+\.md", (ROOT / "mkdocs.yml").read_text()))
    there = {str(path.relative_to(DOCS)) for path in DOCS.rglob("*.md")} | {"api/commands.md"}  # built
    assert entries == there, "a page has a line under `nav` in mkdocs.yml"
