"""Links from pages to files of the repository (../results/..., ../configs/...): the files come along.

On a git host such links just work. The site has no file above docs/, so what a page links to is copied
under repository/, with its path; a linked page (a study's report.md) becomes a page, and what it links to
comes too.
"""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[2]
_LINK = re.compile(r"(?<=\]\()[^()\s#]+(?=[)#\s])")


def _path(uri: str) -> str:
    """The path in the repository of a file of the site."""
    return uri.removeprefix("repository/") if uri.startswith("repository/") else f"docs/{uri}"


def _uri(path: str) -> str:
    """The inverse of `_path`."""
    return path.removeprefix("docs/") if path.startswith("docs/") else f"repository/{path}"


def _target(page: str, link: str) -> str | None:
    """The path in the repository that a page's link means; None where there is no such file."""
    path = posixpath.normpath(posixpath.join(posixpath.dirname(_path(page)), link))
    return path if not path.startswith("..") and (ROOT / path).is_file() else None


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the files that pages link to, and those that these link to."""
    pending = [file for file in files if file.is_documentation_page()]
    while pending:
        page = pending.pop()
        for link in _LINK.findall(page.content_string):
            path = _target(page.src_uri, link)
            if path is None or files.get_file_from_path(_uri(path)) is not None:
                continue
            file = File.generated(config, _uri(path), abs_src_path=str(ROOT / path))
            file.inclusion = InclusionLevel.NOT_IN_NAV
            files.append(file)
            if file.is_documentation_page():
                pending.append(file)
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Point links to where their files are in the site."""
    here = page.file.src_uri
    if here.startswith("repository/"):
        page.meta["search"] = {"exclude": True}  # a thousand rows of numbers

    def moved(link: re.Match[str]) -> str:
        path = _target(here, link[0])
        return link[0] if path is None else posixpath.relpath(_uri(path), posixpath.dirname(here) or ".")

    return _LINK.sub(moved, markdown)
