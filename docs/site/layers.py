"""The picture of the layers, drawn from the imports: `python docs/site/layers.py`.

A matrix of packages in the order of docs/architecture.md. Where data flows one way every dot lies below the
staircase of names. tests/docs/test_layers.py holds docs/figures/layers.svg to the imports.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs" / "figures" / "layers.svg"

# Package -> packages that it imports, and whether only inside functions (when they are called).
Imports = Mapping[str, Mapping[str, bool]]

# Pixels between two packages, and of margins: the longest name stands right of the last column.
_STEP, _MARGIN, _NAME = 19, 14, 110


def layers() -> list[str]:
    """The packages in the order of the table of layers."""
    table = (ROOT / "docs" / "architecture.md").read_text().split("## Layers")[1].split("\n## ")[0]
    first = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    return [name for cell in first for name in re.findall(r"`(\w+)`", cell)]


def packages() -> set[str]:
    """The packages and modules at the top of ecfit; underscored ones are how Python and JAX are set up."""
    found = {p.stem for p in (ROOT / "ecfit").iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    return {name for name in found if not name.startswith("_")}


def imports() -> Imports:
    """What imports what in ecfit."""
    names = packages()
    found: dict[str, dict[str, bool]] = {name: {} for name in names}
    for name in names:
        here = ROOT / "ecfit" / name
        for path in sorted(here.rglob("*.py")) if here.is_dir() else [here.with_suffix(".py")]:
            tree = ast.parse(path.read_text())
            functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
            late = {id(node) for function in functions for node in ast.walk(function)}
            for node in ast.walk(tree):
                for other in set(_imported(node)) & names - {name}:
                    found[name][other] = found[name].get(other, True) and id(node) in late
    return found


def _imported(node: ast.AST) -> Iterator[str]:
    """The packages of ecfit that a statement imports."""
    if isinstance(node, ast.ImportFrom) and node.module == "ecfit":
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        if node.module.startswith("ecfit."):
            yield node.module.split(".")[1]
    elif isinstance(node, ast.Import):
        yield from (a.name.split(".")[1] for a in node.names if a.name.startswith("ecfit."))


def picture(order: list[str], found: Imports) -> str:
    """The matrix as SVG: a row a package, a dot for each import, its name at the end of the row."""
    at = {name: _MARGIN + _STEP * i for i, name in enumerate(order)}
    size = 2 * _MARGIN + _STEP * (len(order) - 1)
    lines, dots, names = [], [], []
    for name in order:
        x = y = at[name]
        used = [at[other] for other in found[name]]
        users = [at[other] for other in order if name in found[other]]
        low, high = min([x, *used]), max([x, *used])
        lines.append(f'<path d="M{low} {y}H{high}M{x} {min([y, *users])}V{max([y, *users])}"/>')
        for other, late in found[name].items():
            title = f"<title>{name} imports {other}{' when called' if late else ''}</title>"
            kind = ' class="late"' if late else ""
            dots.append((y, at[other], f'<circle{kind} cx="{at[other]}" cy="{y}" r="3.5">{title}</circle>'))
        # Beside the name, a dot above the staircase would be covered.
        start = high if x < high < x + _NAME / 2 else x
        names.append(f'<text x="{start + 7}" y="{y}">{name}</text>')
    style = (
        "path{stroke:#d5d9e2;fill:none}circle{fill:#3f51b5;stroke:#3f51b5;stroke-width:1.3}.late{fill:#fff}"
        "text{font:600 11px ui-monospace,monospace;fill:#1f2430;dominant-baseline:central;"
        "paint-order:stroke;stroke:#fff;stroke-width:4px}"
    )
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size + _NAME} {size}" role="img">',
        "<title>Which package imports which</title>",
        f"<style>{style}</style>",
        '<rect width="100%" height="100%" fill="#fff"/>',
        *lines,
        *[dot for *_, dot in sorted(dots)],
        *names,
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    PICTURE.write_text(picture(layers(), imports()))
