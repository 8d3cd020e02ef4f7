"""Which commands there are, by theme, and the page that `ecfit --help` shows of them.

What is asked for most should be there at once. Without cyclopts, which every command's file imports, it is:
the first lines of the commands' docstrings are read from their sources.
"""

import ast
import textwrap
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from shutil import get_terminal_size

# In the order of the page: `module:function` in this folder. A command has its function's name.
COMMANDS: dict[str, tuple[str, ...]] = {
    "Studies": (
        "studies:init",
        "studies:run",
        "studies:report",
        "studies:compare",
        "studies:verify",
        "fits:ship",
    ),
    "Tables": ("tables:table", "foreign:import_", "tables:export_table", "foreign:check"),
    "Fits": ("fits:fit", "fits:certify", "code:export", "code:check_export"),
    "Models": ("models:list_", "models:check_bsdf", "furnaces:furnace"),
}

# Of these what is finished is kept when they are stopped, and found when they are called again.
RESUMED = ("run", "furnace", "ship")

_HEAD = """\
Usage: ecfit COMMAND

From a BSDF to albedo tables with error estimates, rational fits and reports.
"""
_TAIL = """\
ecfit COMMAND --help (-h) shows what a command takes, ecfit --version the version.
"""
_WIDEST = 100
_INDENT = 16


def asks_for_page(words: Sequence[str]) -> bool:
    """Whether the words after `ecfit` name no command: none at all, or help among options only."""
    options = all(word.startswith("-") for word in words)
    return options and (not words or "--help" in words or "-h" in words)


def page() -> str:
    """The first page: every command with the first line of its documentation, as wide as the terminal."""
    width = min(_WIDEST, get_terminal_size().columns)
    parts = [_HEAD]
    for theme, commands in COMMANDS.items():
        parts.append(f"{theme}:")
        for command in commands:
            module, _, function = command.partition(":")
            label = f"  {name_of(function):{_INDENT - 2}}"
            line = _first_lines(module)[function]
            parts.append(textwrap.fill(line, width, initial_indent=label, subsequent_indent=" " * _INDENT))
        parts.append("")
    return "\n".join([*parts, _TAIL])


def name_of(function: str) -> str:
    """What the user types: `check_bsdf` is check-bsdf, and `import_` (a word of Python) is import."""
    return function.strip("_").replace("_", "-")


@cache
def _first_lines(module: str) -> dict[str, str]:
    """First lines of the docstrings of a module's functions, from its source."""
    tree = ast.parse(Path(__file__).with_name(f"{module}.py").read_text("utf-8"))
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    return {node.name: (ast.get_docstring(node) or "").partition("\n")[0] for node in functions}
