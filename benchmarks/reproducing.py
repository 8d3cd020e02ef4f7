"""The tables of "Figure 3" in docs/reproducing-the-paper.md, from the summaries of finished studies.

ecfit run configs/paper.toml && ecfit run configs/paper-energy.toml
python benchmarks/reproducing.py            # on the screen
python benchmarks/reproducing.py --write    # into the document
"""

import argparse
import csv
from pathlib import Path

import common

PAGE = common.DOCS / "reproducing-the-paper.md"
STUDIES = ("paper", "paper-energy")


def degrees(summary: Path) -> str:
    """MAE, count and largest error of every fit: a row a degree, a column a table and family.

    Marked are a pole (!) and a descent that stopped before it converged (*).
    """
    with summary.open(newline="") as file:
        rows = [r for r in csv.DictReader(file) if r["form"] in ("polynomial", "rational")]
    found = {(r["table"], r["form"], int(r["degree"])): cell(r) for r in rows}
    columns = list(dict.fromkeys((table, form) for table, form, _ in found))
    lines = [
        [str(degree), *(found.get((*column, degree), "") for column in columns)]
        for degree in sorted({degree for _, _, degree in found})
    ]
    return common.markdown(["degree", *map(" ".join, columns)], lines)


def cell(row: dict[str, str]) -> str:
    """One fit."""
    mark = " !" if "pole" in row["status"] else "" if row["status"] == "converged" else " *"
    return f"{float(row['mae']):.2e} ({row['coefficients']}), max {float(row['max_error']):.2g}{mark}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--results", type=Path, default=Path("results"), help="folder of all studies")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    given = parser.parse_args()
    made = {study: degrees(given.results / study / "summary.csv") for study in STUDIES}
    print("\n\n".join(made.values()))
    if given.write:
        common.replace_between(PAGE, "reproducing.py", **made)


if __name__ == "__main__":
    main()
