"""The page of a furnace, in Markdown: pictures and numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

from ecfit.config.furnace import FurnaceConfig
from ecfit.rendering.pictures import percent


def page(config: FurnaceConfig, pictures: Mapping[str, Sequence[Any]]) -> str:
    """Markdown text of all pictures, by stem of their files, and the numbers of their spheres."""
    out = [f"# {config.name}", ""]
    if any(members[0].verdict is not None for members in pictures.values()):
        out += [
            "Spheres in a constant light of radiance 1: a surface that keeps all energy cannot be seen. "
            "Below each, the mean and the worst deviation from 1 where mu >= 0.1, noise subtracted. "
            "All numbers: [furnace.csv](furnace.csv).",
            "",
        ]
    for stem, members in pictures.items():
        out += [f"## {stem}", "", f"![{stem}]({stem}.png)", ""]
        if members[0].verdict is not None:
            out += [*table(members), ""]
    return "\n".join(out)


def table(members: Sequence[Any]) -> list[str]:
    """Numbers of one picture: a line a row, mean / worst for each roughness."""
    widths = list(dict.fromkeys(m.sphere.r for m in members))
    lines = ["| | approximation | " + " | ".join(f"r = {r:g}" for r in widths) + " |"]
    lines.append("|---|---|" + "---:|" * len(widths))
    for row in dict.fromkeys(m.sphere.row for m in members):
        cells = [m for m in members if m.sphere.row == row]
        numbers = " | ".join(f"{percent(m.verdict.mean)} / {percent(m.verdict.worst)}" for m in cells)
        lines.append(f"| {row} | {cells[0].sphere.approximations or '-'} | {numbers} |")
    return lines
