"""Planted faults are found by name, clean tables pass, and what cannot be audited is told."""

import json
from dataclasses import replace

import numpy as np
import pytest

import ecfit
from ecfit import Axis, EcfitError, Table, audit
from ecfit._jax import jnp
from ecfit.auditing.subject import subject_of
from ecfit.bsdf.registry import _MODELS
from ecfit.contract import Contract
from ecfit.forms import Terms

COUNT = 8


def spaced(name, spacing="uniform"):
    return Axis.spaced(name, COUNT, spacing=spacing)


def integrated(*names, spacing="uniform", model="conductor", **settings):
    """Values on an 8 x 8 grid, to 1e-4, and their contract."""
    table = ecfit.tabulate(model, {n: spaced(n, spacing) for n in names}, tolerance=1e-4, **settings)
    return table.values, table.contract


def given(values, *names, contract, spacing="uniform"):
    """A table as somebody else would give it: no error estimates."""
    return Table.from_array(values, {n: spaced(n, spacing) for n in names}, contract, finite=False)


def check_report(found):
    lines = found.describe()
    assert all("\n" not in line for line in lines)
    for fault in found.faults:
        assert any(fault in line for line in lines)
    return "\n".join(lines)


def test_a_clean_table_passes_and_nothing_else_is_tried():
    values, contract = integrated("r", "mu")
    found = audit(given(values, "r", "mu", contract=contract))
    assert found.ok
    assert bool(found)
    assert (found.faults, found.trials, found.likely) == ([], (), None)
    assert found.drift.entries.size == COUNT * COUNT - 1  # without the corner
    assert "as claimed" in check_report(found)


def test_alpha_given_as_r():
    values, contract = integrated("alpha", "mu")
    found = audit(given(values, "r", "mu", contract=contract))
    assert not found.ok
    assert found.faults == ["alpha given as r"]
    assert found.likely is not None
    assert found.drift.mean > 0.05
    assert found.likely.drift.mean < 1e-4
    assert "the nodes named r are alpha" in check_report(found)


def test_r_given_as_alpha():
    values, contract = integrated("r", "mu")
    assert audit(given(values, "alpha", "mu", contract=contract)).faults == ["r given as alpha"]


def test_a_correlated_table_called_separable():
    values, contract = integrated("r", "mu", model=ecfit.model("conductor", masking="height-correlated"))
    claimed = replace(contract, options={**contract.options, "masking": "separable"})
    found = audit(given(values, "r", "mu", contract=claimed))
    assert found.faults == ["a height-correlated table called separable"]
    assert "masking is height-correlated, not separable" in check_report(found)


def test_texel_centres_read_at_edges_and_the_reverse():
    values, contract = integrated("r", "mu", spacing="texel-centre")
    found = audit(given(values, "r", "mu", contract=contract))
    assert found.faults == ["texel-centre table read at edges"]
    check_report(found)
    values, contract = integrated("r", "mu")
    found = audit(given(values, "r", "mu", contract=contract, spacing="texel-centre"))
    assert found.faults == ["edge table read at texel centres"]


@pytest.mark.parametrize(
    ("fault", "change"),
    [
        ("1 - E given as E", lambda v: 1.0 - v),
        ("axes swapped", lambda v: v.T),
        ("axis mu flipped", lambda v: v[:, ::-1]),
        ("axis r flipped", lambda v: v[::-1]),
        ("scale 65535 left out", lambda v: v * 65535.0),
        ("scale 100 left out", lambda v: v * 100.0),
    ],
)
def test_how_numbers_are_stored(fault, change):
    values, contract = integrated("r", "mu")
    assert audit(given(change(values), "r", "mu", contract=contract)).faults == [fault]


def test_mu_squared_nodes_read_as_mu():
    t = spaced("mu").nodes
    table = ecfit.tabulate("conductor", {"r": spaced("r"), "mu": t * t}, tolerance=1e-4)
    assert audit(given(table.values, "r", "mu", contract=table.contract)).faults == ["sqrt(mu) given as mu"]


def test_one_wrong_entry_with_its_place():
    values, contract = integrated("r", "mu")
    values = values.copy()
    values[5, 2] += 0.01
    found = audit(given(values, "r", "mu", contract=contract))
    assert found.faults == ["one wrong entry"]
    assert "r = 0.7143, mu = 0.2857" in check_report(found)
    assert found.likely is None


def test_one_wrong_entry_of_many_is_in_the_sample():
    """Sampled, not all compared: the odd one is looked at because it stands out from its neighbours."""
    axes = {"r": Axis.spaced("r", 60), "mu": Axis.spaced("mu", 60)}
    values = np.full((60, 60), 0.8)
    contract = Contract("lambertian", parameters={"rho": 0.8})
    values[17, 31] = 0.805
    with pytest.raises(EcfitError, match="r"):  # the model has no roughness: not a claim that can be audited
        audit(Table.from_array(values, axes, contract))
    rho = Axis.given("rho", np.linspace(0.1, 0.9, 60))
    values = np.repeat(rho.nodes[:, None], 60, axis=1)
    values[17, 31] += 0.005
    table = Table.from_array(values, {"rho": rho, "mu": axes["mu"]}, Contract("lambertian"))
    found = audit(table, samples=64)
    assert found.faults == ["one wrong entry"]
    assert found.drift.entries.size == 64
    assert found.drift.beyond(1e-3).size == 1


def test_nan_is_found_and_the_rest_is_compared():
    values, contract = integrated("r", "mu")
    values = values.copy()
    values[3, 3] = np.nan
    found = audit(given(values, "r", "mu", contract=contract))
    assert found.faults == ["NaN"]
    assert found.within
    assert not found.ok
    assert "1 of 64 values are NaN" in check_report(found)


def test_cosines_kept_away_from_zero():
    mu = np.maximum(spaced("mu").nodes, 0.02)
    table = ecfit.tabulate("conductor", {"r": spaced("r"), "mu": mu}, tolerance=1e-4)
    assert audit(given(table.values, "r", "mu", contract=table.contract)).faults == [
        "mu kept at 0.02 or more"
    ]


class Sheet(ecfit.BSDF):
    """Half of the light is reflected, a fifth of the radiance transmitted into a denser medium."""

    transmissive = True
    conserving = False

    rho: jnp.ndarray = ecfit.parameter(0.5, 0.0, 1.0, "reflectance")

    def f(self, wo, wi):
        return jnp.where(wi[2] > 0.0, self.rho, 0.2) / jnp.pi

    def relative_ior(self):
        return jnp.asarray(1.5)


@pytest.fixture
def sheet():
    ecfit.register("audited-sheet")(Sheet)
    yield "audited-sheet"
    del _MODELS["audited-sheet"]


def test_missing_eta_squared(sheet):
    axes = {"rho": Axis.spaced("rho", COUNT, 0.1, 0.5), "mu": spaced("mu", "texel-centre")}
    values = np.repeat(axes["rho"].nodes[:, None] + 0.2, COUNT, axis=1)  # without the factor 2.25
    found = audit(Table.from_array(values, axes, Contract(sheet)))
    assert found.faults == ["missing eta^2"]
    assert "radiance transport, not energy" in check_report(found)
    right = np.repeat(axes["rho"].nodes[:, None] + 0.2 * 2.25, COUNT, axis=1)
    assert audit(Table.from_array(right, axes, Contract(sheet))).ok
    back = audit(Table.from_array(right, axes, Contract(sheet, transport="radiance")))
    assert back.faults == ["eta^2 too much"]


def with_pole(place, gap):
    """0.7 (mu - place) / (mu - place - gap): near 0.7 but for a pole right of `place`."""
    terms = Terms(np.array([[0], [1]]), np.array([[1]]))
    shift = place + gap
    coefficients = np.array([0.7 * place / shift, -0.7 / shift, -1.0 / shift])
    contract = Contract("lambertian", parameters={"rho": 0.7})
    return ecfit.Approximation.quotient(
        "planted", "rational", "1", ("mu",), terms, coefficients, ((0.0, 1.0),), contract
    )


def test_a_pole_of_a_coefficient_file(tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(with_pole(0.3333, 1e-6).to_dict()))
    found = audit(path)
    assert found.faults == ["a pole"]
    assert found.within  # no sampled point is near it
    assert not found.ok
    assert "denominator falls to" in check_report(found)
    path.write_text(json.dumps(with_pole(-0.3, -1e-6).to_dict()))
    assert audit(path).ok


def test_a_pole_in_a_table():
    mu = Axis.spaced("mu", 64)
    contract = Contract("lambertian", parameters={"rho": 0.7})
    values = with_pole(17.5 / 63.0, 2.0 / 63.0).on_grid([mu.nodes])  # infinite between nodes 19 and 20
    (finding,) = subject_of(Table.from_array(values, {"mu": mu}, contract), None, None).findings
    assert finding.name == "a pole"
    assert "from 3.5 to -2.1 along mu" in finding.sentence
    steep = np.linspace(-0.4, 1.4, 64)  # bad, but no pole
    assert subject_of(Table.from_array(steep, {"mu": mu}, contract), None, None).findings == ()


@pytest.mark.slow
def test_fits_are_compared_with_what_they_state():
    found = audit("conductor-10")
    assert found.ok
    assert "its stated largest error" in found.why
    assert audit("kulla-conty-2017", contract=ecfit.published("kulla-conty-2017").contract).ok


def test_the_tolerance_is_the_subject_s_own_or_as_asked():
    values, contract = integrated("r", "mu")
    table = given(values, "r", "mu", contract=contract)
    assert subject_of(table, None, None).tolerance == 1e-3
    assert subject_of(replace(table, errors=0.0 * values + 1e-9), None, None).tolerance == 1e-6
    assert subject_of(replace(table, errors=0.0 * values + 1e-5), None, None).tolerance == 2e-5
    assert subject_of("kulla-conty-2017", None, None).tolerance == 5e-2
    assert subject_of("conductor-10", None, None).tolerance < 5e-3
    off = given(values - 2e-3, "r", "mu", contract=contract)
    found = audit(off, tolerance=2.2e-3)
    assert found.ok
    assert found.drift.largest == pytest.approx(2e-3, abs=2e-4)
    assert found.why == "as asked for"
    assert not replace(found, tolerance=1.5e-3).ok


@pytest.fixture(scope="module")
def precise():
    """A table of a small part of the domain, where nothing is steep: to 1e-8 in a moment."""
    axes = {"r": Axis.spaced("r", 5, 0.4, 1.0), "mu": Axis.spaced("mu", 6, 0.2, 1.0)}
    return ecfit.tabulate("conductor", axes, tolerance=1e-8)


@pytest.mark.parametrize(
    ("number", "ending", "tolerance"),
    # Twice half a step of the type; nothing is judged more sharply than our own tables.
    [("uint8", ".h", 1 / 255), ("uint16", ".csv", 1 / 65535), ("float32", ".exr", 1e-6)],
)
def test_a_file_of_ours_is_judged_by_the_errors_that_it_states(tmp_path, precise, number, ending, tolerance):
    path = tmp_path / f"t{ending}"
    written = ecfit.write_table(precise, path, number=number)
    back = ecfit.read_layout(path)
    off = np.abs(back.values - precise.values).max()
    assert 0.0 < off <= written.bound <= back.errors.min() <= written.bound + 1e-8
    found = audit(back)
    assert found.ok
    assert found.tolerance == pytest.approx(tolerance, rel=1e-2)
    assert found.drift.largest == pytest.approx(off, abs=1e-8)


def test_a_file_states_no_errors_where_they_are_unknown(tmp_path, precise):
    unknown = Table.from_array(precise.values, {a.name: a for a in precise.axes}, precise.contract)
    ecfit.write_table(unknown, tmp_path / "t.h", number="float32")
    back = ecfit.read_layout(tmp_path / "t.h")
    assert not back.estimated
    assert audit(back).tolerance == 1e-3


@pytest.mark.parametrize(
    ("subject", "settings", "words"),
    [
        (3, {}, "an audit needs a table"),
        ("nothing", {}, "unknown shipped or published fit"),
        ("nothing.npz", {}, "no such table"),
        ("nothing.json", {}, "no such file"),
        ("conductor-10", {"samples": 2}, "samples must be 8 or more"),
        ("conductor-10", {"seed": -1}, "seed must be 0 or more"),
        ("conductor-10", {"tolerance": 0.0}, "tolerance must be a positive number"),
        ("conductor-10", {"contract": Contract("unknown")}, "names no model"),
    ],
)
def test_what_cannot_be_audited_is_told(subject, settings, words):
    with pytest.raises(EcfitError, match=words) as caught:
        audit(subject, **settings)
    assert "\n" not in str(caught.value)


# Slow: every mistake alone must fail first, which compiles the integrals of every other contract.


@pytest.mark.slow
@pytest.mark.parametrize(
    ("faults", "names", "spacing", "change"),
    [
        ({"texel-centre table read at edges", "alpha given as r"}, ("alpha", "mu"), "texel-centre", None),
        ({"axes swapped", "alpha given as r"}, ("alpha", "mu"), "uniform", lambda v: v.T),
        ({"axis mu flipped", "1 - E given as E"}, ("r", "mu"), "uniform", lambda v: 1.0 - v[:, ::-1]),
    ],
)
def test_two_mistakes(faults, names, spacing, change):
    values, contract = integrated(*names, spacing=spacing)
    found = audit(given(values if change is None else change(values), "r", "mu", contract=contract))
    assert set(found.faults) == faults


@pytest.mark.slow
def test_a_mistake_of_the_contract_with_another():
    values, contract = integrated("alpha", "mu", model=ecfit.model("conductor", masking="height-correlated"))
    claimed = replace(contract, options={**contract.options, "masking": "separable"})
    found = audit(given(values, "r", "mu", contract=claimed))
    assert set(found.faults) == {"alpha given as r", "a height-correlated table called separable"}


@pytest.mark.slow
@pytest.mark.parametrize("side", ["entering", "leaving"])
def test_a_dielectric_without_eta_squared(side):
    axes = {"F0": [0.02, 0.08, 0.2], "r": [0.2, 0.5, 0.9], "mu": [0.1, 0.4, 0.7, 1.0]}
    glass = ecfit.model("dielectric", side=side)
    table = ecfit.tabulate(glass, axes, transport="radiance", tolerance=1e-5)
    claimed = replace(table.contract, transport="energy")
    found = audit(Table.from_array(table.values, axes, claimed))
    assert found.faults == ["missing eta^2"]
    assert audit(Table.from_array(table.values, axes, table.contract)).ok


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "axes", "settings"),
    [
        ("conductor", {"r": 8, "mu": 8}, {"quantity": "schlick-b"}),
        ("conductor", {"alpha": 8}, {"quantity": "average-albedo"}),
        ("eon", {"diffuse_roughness": 6, "mu": 6}, {}),
        ("burley", {"r": 6, "mu": 6}, {}),
        ("thin-dielectric", {"r": 5, "mu": 5}, {}),
        ("dielectric", {"F0": [0.02, 0.1, 0.3], "r": 4, "mu": 4}, {"lobe": "transmission"}),
    ],
)
def test_no_false_alarm_on_clean_tables(model, axes, settings):
    table = ecfit.tabulate(model, axes, tolerance=1e-6, **settings)
    found = audit(table)
    assert found.ok, str(found)
    assert found.trials == ()
