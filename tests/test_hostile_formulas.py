"""Coefficient files: whatever a JSON file of a fit holds, reading and using it ends, and executes nothing."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import changed, changes, damaged, damages, guarded, many, settled, tried
from hypothesis import strategies as st

import ecfit
from ecfit.approximation import find
from ecfit.files import read_json
from ecfit.tables.table import Table

ROOT = Path(__file__).parent.parent

# A file of each kind of formula.
FILES = {
    "quotient": ROOT / "ecfit/data/published/kulla-conty-2017.json",
    "rational": ROOT / "results/conductor-clamped/fits/conductor-rational-3.json",
    "structured": ROOT / "ecfit/data/shipped/conductor-10.json",
    "written": ROOT / "ecfit/data/published/karis-mobile.json",
    "composed": ROOT / "ecfit/data/shipped/schlick-a-32.json",
    "module": ROOT / "results/gotanda/fits/squared-ratio-2.json",
}


@pytest.fixture(scope="module")
def originals() -> dict[str, Any]:
    axis = ecfit.Axis.spaced("mu", 3)
    mean = Table.from_array(np.array([0.2, 0.5, 0.9]), {"mu": axis}, {"model": "unknown"})
    found = {name: json.loads(path.read_text()) for name, path in FILES.items()}
    lookup = json.loads(json.dumps(ecfit.Approximation.lookup(mean).to_dict()))
    return {**found, "lookup": lookup}


def use(path: Path) -> None:
    """What commands do with a file: read, evaluate, describe, write."""
    data = read_json(path)
    if isinstance(data, dict) and "fit" in data:
        made: Any = ecfit.Fit.from_dict(data, str(path)).approximation
    else:
        made = find(str(path))
    centre = [np.array([0.5 * (low + high)]) for low, high in made.domain]
    assert np.shape(made.at(centre)) == (1,)
    assert json.dumps(made.to_dict())
    if made.form != "lookup":
        made.expression()


@pytest.mark.parametrize("kind", [*FILES, "lookup"])
@many(10, 300)
def test_a_changed_file_of_any_kind_is_a_formula_or_an_error(
    tmp_path: Path, originals: dict[str, Any], kind: str, cases: int
):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(originals[kind]))
    assert settled(lambda: use(path))

    def case(made: list[Any]) -> None:
        path.write_text(json.dumps(changed(originals[kind], made)))
        settled(lambda: use(path))

    with guarded(tmp_path):
        tried(cases, changes, case)


@many(10, 300)
def test_damaged_bytes_are_a_formula_or_an_error(tmp_path: Path, originals: dict[str, Any], cases: int):
    path = tmp_path / "fit.json"
    good = json.dumps(originals["rational"]).encode()

    def case(damage: Any) -> None:
        path.write_bytes(damaged(good, damage))
        settled(lambda: use(path))

    with guarded(tmp_path):
        tried(cases, damages, case)


@many(40, 500)
def test_text_is_a_formula_or_an_error_and_is_never_executed(tmp_path: Path, cases: int):
    """Pieces of formulas and of Python, in any order."""
    pieces = st.sampled_from([
        "mu", "r", "1", "2.5", "1e308", "0", "+", "-", "*", "/", "**", "(", ")", ",", " ", "sqrt(", "exp(",
        "log(",
        "max(", "min(", "abs(", "saturate(", "__import__('os')", ".system", "[0]", "lambda: ", "'x'",
        "f'{mu}'", "\\",
        "if", "else", "==", "@", "~", "not ", "\n", "\t", "\x00", "é", "10**400", "=", ":=", "{}",
        "print(1)", "#",
    ])  # fmt: skip
    text = st.lists(pieces, max_size=14).map("".join)
    from ecfit.expressions import parse
    from ecfit.expressions import value as evaluated

    def case(formula: str) -> None:
        def call() -> None:
            node = parse(formula, ["mu", "r"])
            with np.errstate(all="ignore"):
                evaluated(node, {"mu": np.array([0.5]), "r": np.array([0.25])})

        settled(call)

    with guarded(tmp_path):
        tried(cases, text, case)
