"""configs/published.toml judges every published formula."""

from pathlib import Path

import pytest

import ecfit
from ecfit.approximation import published_names
from ecfit.config import read_config
from ecfit.errors import EcfitError
from ecfit.study.plan import make_plan
from ecfit.tables.scattered import of_contract

CONFIG = Path(__file__).parent.parent.parent / "configs" / "published.toml"


def has_truth(name: str) -> bool:
    """Whether the contract is one of a table: a registered model, and no coordinate that is fixed."""
    try:
        of_contract(ecfit.published(name).contract)
    except EcfitError:
        return False
    return True


def test_no_formula_is_forgotten():
    plan = make_plan(read_config(CONFIG), CONFIG.parent)
    judged = [formula.name for found in plan.compare.values() for formula in found]
    assert sorted(judged) == [name for name in published_names() if has_truth(name)]


def test_formulas_are_judged_on_what_they_stand_for():
    plan = make_plan(read_config(CONFIG), CONFIG.parent)
    for table, found in plan.compare.items():
        contract = plan.requests[table].contract
        for formula in found:
            assert formula.contract.differences(contract) == [], formula.name


@pytest.mark.parametrize("table", ["conductor", "conductor-correlated"])
def test_tables_compete(table: str):
    plan = make_plan(read_config(CONFIG), CONFIG.parent)
    assert [r.grid.shape for r in plan.lookups[table]] == [(16, 16), (16, 16), (32, 32), (32, 32)]
