"""Certificates are granted to forms that deserve them, and refused with the place where they fail."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ecfit
from ecfit.approximation import Approximation, Written
from ecfit.approximation.compose import compose
from ecfit.approximation.lookup import Lookup
from ecfit.approximation.structured import StructuredFormula
from ecfit.certify import Certificate, Sampling, certify
from ecfit.cli import main
from ecfit.contract import Contract
from ecfit.errors import EcfitError
from ecfit.files import read_json, write_json

Make = Callable[..., Approximation]


def unknown_model(name: str) -> Approximation:
    """A published fit without its model: proofs only, no integrals."""
    found = ecfit.published(name)
    return replace(found, contract=Contract("unknown"))


@pytest.fixture(scope="module")
def granted(corner: Make) -> Certificate:
    return certify(corner(), samples=300, tolerance=1e-6)


def test_the_corner_form_is_certified(granted: Certificate):
    assert granted.certified
    assert not granted.refusals
    (q,) = granted.divisors
    assert q.claim == "Q' > 0"
    assert 0.1 < q.bound <= q.value < 0.102
    values = granted.values
    assert values is not None
    assert 0.3 < values.low <= values.least < 0.31
    assert values.high == 1.0
    assert "deficit" in values.upper
    assert values.identity is not None
    assert values.identity < 1e-12
    assert granted.at_corner == 1.0


def test_its_errors_are_those_measured_elsewhere(granted: Certificate):
    errors = granted.errors
    assert errors is not None
    assert errors.mae == pytest.approx(3.6e-4, rel=0.15)
    assert errors.max_error < 2.4e-3
    assert 0.0 < errors.furnace_mean <= errors.furnace_p99 <= errors.furnace_max
    assert errors.points == 300
    assert granted.corner_errors is not None
    assert granted.corner_errors.max_error < 5e-3


def test_narrow_arithmetic(granted: Certificate):
    bound = granted.single_bound
    assert bound is not None
    # A bound, not absurdly above what is measured.
    assert max(granted.single.largest, granted.single_hard.largest) < bound < 1e-5
    assert granted.single_hard.not_finite == 0
    # In half precision alpha^3 and mu^3 underflow near the corner; in t, m and rho they do not occur.
    assert granted.half_hard.not_finite > 0
    assert granted.half_chart is not None
    assert granted.half_chart.not_finite == 0
    assert granted.half_chart.largest < 5e-3


def test_errors_in_half_precision(granted: Certificate, corner: Make):
    """A form made for it keeps its bounds, its proofs and, where the plain form underflows, its digits."""
    plain = corner()
    formula = plain.formula
    assert isinstance(formula, StructuredFormula)
    charted = replace(formula, structure=replace(formula.structure, charted=True))
    made = certify(replace(plain, formula=charted), samples=300, tolerance=1e-6)
    assert made.certified
    assert [p.claim for p in made.divisors] == ["Q' > 0"]
    assert made.values == granted.values
    assert made.half_hard.not_finite == 0
    assert made.half_hard.largest < 5e-3
    assert made.single_bound is not None
    assert max(made.single.largest, made.single_hard.largest) < made.single_bound < 1e-5
    assert made.errors is not None
    assert made.half_errors is not None
    assert made.errors.max_error < made.half_errors.max_error < 5e-3
    assert any("all in half precision" in line for line in made.describe())


def test_a_certificate_from_before_errors_in_half_precision(granted: Certificate):
    old = granted.to_dict()
    del old["half_errors"]
    assert Certificate.from_dict(old) == replace(granted, half_errors=None)


def test_it_says_what_is_proved_and_what_is_a_sample(granted: Certificate):
    text = "\n".join(granted.describe())
    proved, measured = text.split("measured at random points")
    assert "corner: certified" in proved
    assert "closed domain" in proved
    assert "MAE" not in proved
    assert "not proofs" in measured
    assert "half precision in t, m, rho" in measured


def test_it_survives_json(granted: Certificate, tmp_path: Path):
    assert Certificate.from_dict(json.loads(json.dumps(granted.to_dict()))) == granted
    refused = certify(unknown_model("sforza-pellacini-2022-glossy"), sampling=Sampling(5))
    write_json(tmp_path / "c.json", refused.to_dict())
    assert Certificate.from_dict(read_json(tmp_path / "c.json")) == refused
    with pytest.raises(EcfitError, match="malformed certificate"):
        Certificate.from_dict({"name": "x"})


def test_a_true_pole_is_refused_with_its_place():
    found = certify(unknown_model("sforza-pellacini-2022-glossy"), samples=100)
    assert not found.certified
    (q,) = found.divisors
    assert not q.proven
    assert q.value < 0.0
    assert q.place["F0"] == pytest.approx(0.0, abs=0.02)
    assert q.place["mu"] == pytest.approx(0.047, abs=0.02)
    assert found.values is None
    assert found.single_bound is None
    assert "Q > 0: false" in found.refusals[0]
    assert found.no_truth


def test_values_above_what_a_quantity_can_be_are_refused_with_their_place():
    found = certify(unknown_model("sforza-pellacini-2022-conductor"), samples=100)
    assert not found.certified
    assert found.divisors[0].proven
    (reason,) = found.refusals
    assert "exceed 1, by 0.024" in reason
    values = found.values
    assert values is not None
    assert values.high >= values.greatest > 1.02


@pytest.mark.slow
def test_radiance_that_leaves_is_compared_with_the_squared_index():
    found = certify(ecfit.published("sforza-pellacini-2022-dielectric-leaving"), samples=50)
    assert not found.certified
    assert any("exceed ior^2" in reason for reason in found.refusals)


def test_a_published_fit_that_keeps_its_promises_is_certified():
    found = certify(ecfit.published("deon-average-fresnel"), samples=50)
    assert found.certified
    assert found.errors is not None
    assert found.errors.max_error < 3e-3
    assert found.corner_errors is None


def test_a_denominator_that_is_zero_at_a_point_between_nodes_is_refused(written: Make):
    found = certify(written("0.5*((r - 0.3137)**2 + mu)/((r - 0.3137)**2 + mu*mu)"), samples=50)
    assert not found.certified
    assert "not proved" in found.refusals[0] or "false" in found.refusals[0]


def test_a_formula_that_is_not_real_everywhere_is_refused(written: Make):
    found = certify(written("sqrt(mu - 0.1)*0.5"), samples=50)
    assert not found.certified
    assert any("root" in reason for reason in found.refusals)
    assert found.single.not_finite > 0
    found = certify(written("0.5 + 0.001*log(mu)", domain=((0.0, 1.0), (0.0, 1.0))), samples=50)
    assert any("logarithm" in reason for reason in found.refusals)


def test_tables_have_no_certificate():
    lookup = Lookup(np.array([0.2, 0.5]), ((0.0, 1.0),), ("identity",))
    table = Approximation("t", "lookup", "1", ("mu",), lookup, ((0.0, 1.0),), Contract("unknown"))
    with pytest.raises(EcfitError, match="table"):
        certify(table)


@pytest.mark.parametrize("name", [pytest.param("two_point", marks=pytest.mark.slow), "average"])
def test_other_heads(name: str, request: pytest.FixtureRequest):
    found = certify(request.getfixturevalue(name)(), samples=100)
    assert found.certified
    assert found.values is not None
    assert "deficit" in found.values.upper
    assert found.errors is None
    assert "names no model" in found.no_truth


def test_command(capsys: pytest.CaptureFixture, tmp_path: Path):
    output = tmp_path / "certificate.json"
    with pytest.raises(SystemExit) as done:
        main(["certify", "osl-average-fresnel", "--samples", "20", "--output", str(output)])
    assert not done.value.code
    assert "osl-average-fresnel: certified" in capsys.readouterr().out
    assert read_json(output)["certified"] is True
    with pytest.raises(SystemExit) as refused:
        main(["certify", "f82-average-fresnel", "--samples", "20"])
    assert refused.value.code == 1
    assert "NOT CERTIFIED" in capsys.readouterr().out
    for arguments in (["nothing"], [str(tmp_path / "none.json")], ["osl-average-fresnel", "--samples", "0"]):
        with pytest.raises(SystemExit) as bad:
            main(["certify", *arguments])
        assert bad.value.code == 2
        assert "error: " in capsys.readouterr().err


def composed(text: str, parts: dict[str, Approximation]) -> Certificate:
    return certify(compose("c", text, parts, Contract("unknown", transport="energy")), samples=200)


def part(text: str, *names: str) -> Approximation:
    domain = ((0.0, 1.0),) * len(names)
    return Approximation("p", "written", "1", names, Written(names, text), domain, Contract("unknown"))


@pytest.mark.parametrize(
    "second",
    [
        part("(1 - mu)**5", "mu"),
        pytest.param(part("F0 + (1 - F0)*(1 - mu)**5", "mu", "F0"), marks=pytest.mark.slow),
    ],
    ids=["mu", "mu-F0"],
)
def test_a_composed_form_is_certified_by_its_parts(corner: Make, second: Approximation):
    """E1 E_spec of a corner form and a written one: each part's range bounds the product exactly."""
    found = composed("E*S", {"E": corner(), "S": second})
    assert found.certified, found.refusals
    assert found.charted
    assert found.values is not None
    assert found.values.low >= -1e-12
    assert found.values.high == pytest.approx(1.0, abs=1e-9)
    assert [p.claim for p in found.divisors] == ["E: Q' > 0"]


def test_what_may_fall_below_0_is_refused_unless_its_text_clamps_it():
    parts = {"E": part("1 - 0.7*(1 - mu)**2*F0", "mu", "F0"), "S": part("(1 - mu)**5", "mu")}
    clamped = composed("max(E - 2*S, 0)", parts)
    assert clamped.values is not None
    assert clamped.values.low == 0.0
    refused = composed("E - 2*S", parts)
    assert not refused.certified
    assert "below 0, by 1.7" in refused.refusals[0]
