"""Every snippet of the documentation is run, or says why not.

Fenced and indented blocks are what CommonMark says they are (markdown-it). A page is one test: its blocks
run in order, Python in one namespace, in a folder of its own with the repository's configs and examples.
Comments before a block:

    <!-- slow: why -->           run by `make test-all` only, and checked by `make test`
    <!-- not run: why -->        only checked: Python compiled, commands parsed with their options and files
    <!-- setup: python ... -->   what a page takes for granted: run, not shown

Commands (sh, and indented blocks) of `ecfit` run in this process. Sessions (pycon) are doctests: their
output is compared. TOML is a study, or a section of one, and is checked as a study is. Text is what somebody
prints. Code of other languages needs the renderer around it, and must say so.
"""

import doctest
import re
import shlex
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
from markdown_it import MarkdownIt

import ecfit
from ecfit import cli
from ecfit.bsdf import registry
from ecfit.cli.app import app
from ecfit.config import read_config
from ecfit.forms import modules

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])

_MARK = re.compile(r"<!-- (slow|not run): (.+?) -->", re.DOTALL)
_SETUP = re.compile(r"<!-- setup: python\n(.*?)-->", re.DOTALL)
# Of the repository; whoever reads a page at a terminal has them.
_FOLDERS = ("benchmarks", "configs", "examples", "results/paper-small/fits")
# A command runs these, each in its own way; a snippet of them is never run here.
_OTHERS = ("apt-get", "cc", "cd", "dask", "make", "pip", "pytest", "python", "source", "xdg-open")
# What a fragment of a study is checked with: a fit for a head, and the table that a fit asks for.
_HEAD = """
[[fits]]
tables = ["conductor"]
form = "structured"
features = ["mu", "alpha"]
terms = { numerators = [[[0, 0], [1, 0]]], denominator = [[0, 0], [0, 1]] }
"""
_TABLE = '\n[[tables]]\nname = "{}"\nmodel = "conductor"\naxes = {{ r = 8, mu = 8 }}\n'


@dataclass(frozen=True)
class Block:
    """A piece of code of a page, and what the comment before it says: "", "slow", "not run" or "setup"."""

    page: Path
    line: int
    language: str
    text: str
    mark: str

    @property
    def place(self) -> str:
        """As an editor jumps to it."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page: Path) -> Iterator[Block]:
    """The code of a page, in its order."""
    mark = ""
    for token in MarkdownIt("commonmark").parse(page.read_text()):
        line = token.map[0] + 1 if token.map else 0
        if token.type == "html_block":
            setup = _SETUP.match(token.content)
            if setup:
                yield Block(page, line, "python", setup[1], "setup")
            said = _MARK.match(token.content)
            mark = said[1] if said else ""
            continue
        if token.type == "fence":
            yield Block(page, line + 1, token.info.strip(), token.content, mark)
        elif token.type == "code_block":
            yield Block(page, line, "sh", token.content, mark)
        mark = ""


ALL = {page: list(blocks(page)) for page in PAGES}


def pages(mark: str | None = None) -> list[Any]:
    """The pages with code, or with code of a mark, as parameters."""
    found = [p for p, code in ALL.items() if code and (mark is None or any(b.mark == mark for b in code))]
    return [pytest.param(p, id=str(p.relative_to(ROOT))) for p in found]


def commands(block: Block) -> Iterator[list[str]]:
    """The words of each command of a shell snippet."""
    for line in block.text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        while words:
            end = words.index("&&") if "&&" in words else len(words)
            yield words[:end]
            words = words[end + 1 :]


def check_command(words: list[str]) -> None:
    """That a command exists, with these options, and its files of the repository too."""
    while re.match(r"[A-Z_]+=", words[0]):  # a variable of the environment
        words = words[1:]
    program = words[0].removeprefix(".venv/bin/")
    if program == "ecfit":
        app.parse_args(words[1:], exit_on_error=False, print_error=False)
    else:
        assert program in _OTHERS, f"what is '{program}'? Text is fenced as text, a formula too"
    if program == "make":
        targets = set(re.findall(r"^(\w[\w-]*):", (ROOT / "Makefile").read_text(), re.MULTILINE))
        assert {w for w in words[1:] if "=" not in w} <= targets
    for word in words[1:]:
        if word.startswith(tuple(f"{folder}/" for folder in _FOLDERS)):
            assert (ROOT / word).exists(), f"there is no {word}"


def run_command(words: list[str]) -> None:
    """Run a command of ecfit in this process; audits and comparisons that find something exit with 1."""
    code: Any = 0
    try:
        cli.main(words[1:])
    except SystemExit as stop:
        code = stop.code
    found = words[1] in ("check", "compare") and code == 1
    assert found or not code, f"exit code {code}: {shlex.join(words)}"


def run_session(session: doctest.DocTest) -> None:
    """Run a doctest; "..." stands for any text, and of an exception's traceback only the last line counts."""
    told: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    runner.run(session, out=told.append, clear_globs=False)
    assert not runner.failures, "".join(told)


def check_study(block: Block, folder: Path) -> None:
    """That a study, or a section of one, has no fault: missing parts are added."""
    text = block.text
    if text.startswith("head ="):
        text = _HEAD + text
    if not re.search(r"^name = .*\n\n?(?=\[\[)", text, re.MULTILINE):
        text = f'name = "page"\n{text}'
    for name in re.findall(r'tables = \["([\w.-]+)"\]', text)[:1]:
        if "[[tables]]" not in text:
            text += _TABLE.format(name)
    path = folder / "snippet.toml"
    path.write_text(text)
    read_config(path)


def run(block: Block, names: dict[str, Any], folder: Path, slow: bool = False) -> None:
    """Do with a block what its language and its mark ask for."""
    checked_only = block.mark == "not run" or (block.mark == "slow" and not slow)
    if block.language == "python":
        # Line numbers of the page, so that a traceback shows the line.
        code = compile("\n" * (block.line - 1) + block.text, str(block.page), "exec")
        if not checked_only:
            exec(code, names)
    elif block.language == "pycon":
        parse = doctest.DocTestParser().get_doctest
        session = parse(block.text, names, block.place, str(block.page), block.line - 1)
        if not checked_only:
            run_session(session)
            names.update(session.globs)
    elif block.language == "sh":
        for words in commands(block):
            check_command(words)
            if not checked_only:
                assert words[0].endswith("ecfit"), f"'{words[0]}' is not run: say so before the block"
                run_command(words)
    elif block.language == "toml":
        check_study(block, folder)
    elif block.language != "text":
        assert block.language, "no language: sh, python, toml, text, c, glsl, ..."
        assert checked_only, f"{block.language} is not run here: say so before the block"


@pytest.fixture
def terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder as a clone of the repository has it, and what snippets change as it was."""
    for folder in _FOLDERS:
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "_MODELS", dict(registry._MODELS))
    monkeypatch.setattr(modules, "_MODULES", dict(modules._MODULES))
    yield tmp_path
    plt.close("all")


def run_page(page: Path, folder: Path, slow: bool = False) -> None:
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in ALL[page]:
        try:
            run(block, names, folder, slow)
        except Exception as error:
            error.add_note(f"in the snippet at {block.place}")
            raise


@pytest.mark.parametrize("page", pages())
def test_the_snippets_of_a_page_run(page: Path, terminal: Path):
    run_page(page, terminal)


@pytest.mark.slow
@pytest.mark.parametrize("page", pages("slow"))
def test_all_snippets_of_a_page_run(page: Path, terminal: Path):
    run_page(page, terminal, slow=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("```sh\necfit tabel conductor\n```", "tabel"),
        ("```sh\necfit export conductor-10 --langauge glsl\n```", "--langauge"),
        ("    ecfit run configs/none.toml", "there is no configs/none.toml"),
        ("    E = 1 - alpha", "Text is fenced as text"),
        ("    make stduy", "stduy"),
        ("```\nno language\n```", "no language"),
        ("```glsl\nfloat x;\n```", "say so before the block"),
        ("```python\n1 / 0\n```", "division by zero"),
        ("```pycon\n>>> 1 + 1\n3\n```", "Got:\n      2"),
        ("<!-- not run: broken -->\n```python\n1 +\n```", "invalid syntax"),
        ('```toml\n[[fits]]\ntables = ["conductor"]\nform = "rational"\ndegre = 3\n```', "degre"),
    ],
)
def test_a_broken_snippet_fails(text: str, message: str, terminal: Path):
    path = terminal / "page.md"
    path.write_text(text)
    (block,) = blocks(path)
    with pytest.raises(Exception, match=re.escape(message)):
        run(replace(block, page=ROOT / "docs" / "page.md"), {}, terminal)


def test_a_block_is_read_with_its_mark_and_its_set_up(tmp_path: Path):
    path = tmp_path / "page.md"
    setup, slow = "<!-- setup: python\nx = 1\n-->\n\n", "<!-- slow: a minute -->\n```python\nx\n```\n\n"
    path.write_text(f"{setup}{slow}    ecfit list\n")
    found = [(b.language, b.text, b.mark) for b in blocks(path)]
    assert found == [("python", "x = 1\n", "setup"), ("python", "x\n", "slow"), ("sh", "ecfit list\n", "")]


def test_the_pages_are_those_of_the_repository():
    assert len(PAGES) > 30
    assert sum(b.mark == "not run" for code in ALL.values() for b in code) < sum(map(len, ALL.values())) / 2
    assert ecfit.__version__
