"""Structures: one function in coordinates and in the chart, defined up to the corner, read back exactly."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.expressions import value
from ecfit.forms import Structure, head
from ecfit.forms.features import FEATURES, monomial, scaled
from ecfit.forms.heads import HEADS
from ecfit.forms.structured import chart_points

NUMERATOR = [[1, 0], [0, 1], [3, 0], [2, 1], [3.5, 0], [0.5, 3]]
DENOMINATOR = [[3, 0], [0, 3], [1.5, 1.5], [4.5, 1.5], [0.5, 3]]
COEFFICIENTS = np.array(
    [0.06256, 0.11125, 0.89389, 0.55689, -0.57248, 0.20031, 0.17076, 0.32043, 0.36454, -0.05526]
)


def conductor() -> Structure:
    return Structure(head("corner"), ("alpha", "mu"), (np.array(NUMERATOR),), np.array(DENOMINATOR))


def of_head(name: str) -> Structure:
    """A structure of any head, with half-integer powers."""
    found = HEADS[name]
    features = ("alpha", "mu", "F0")
    rows = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1.5, 1], [0, 2, 0]])
    return Structure(found, features, (rows,) * found.ratios, rows)


def by_hand(alpha, mu):
    p = sum(c * alpha**a * mu**b for c, (a, b) in zip(COEFFICIENTS[:6], NUMERATOR, strict=True))
    q = sum(c * alpha**a * mu**b for c, (a, b) in zip([1.0, *COEFFICIENTS[6:]], DENOMINATOR, strict=True))
    return 1.0 - alpha**2 * p / q


POINTS = {n: np.random.default_rng(i).uniform(1e-3, 1.0, 300) for i, n in enumerate(("alpha", "mu", "F0"))}


def test_the_value_is_that_of_the_formula():
    made = conductor()
    assert made.variables == ("mu", "alpha")
    assert made.count == 10
    got = value(made.expression(COEFFICIENTS), POINTS)
    np.testing.assert_allclose(got, by_hand(POINTS["alpha"], POINTS["mu"]), rtol=1e-13)


@pytest.mark.parametrize("name", HEADS)
def test_chart_and_coordinates_agree(name: str):
    made = of_head(name)
    coefficients = np.random.default_rng(3).uniform(0.0, 1.0, made.count)
    points = {**POINTS, "ior": 1.0 + POINTS["F0"], "diffuse_roughness": POINTS["F0"], "sigma": POINTS["F0"]}
    expected = value(made.expression(coefficients), points)
    in_chart, held, q = made.chart(coefficients)
    chart = chart_points(points)
    np.testing.assert_allclose(value(in_chart, chart), expected, rtol=1e-11, atol=1e-12)
    plain_q = value(made.denominator_expression(coefficients), points)
    np.testing.assert_allclose(value(q, chart), plain_q, rtol=1e-12)
    for limit, rest in zip(made.head.held, held, strict=True):
        shared = value(monomial(limit.shared, {n: scaled(n) for n in FEATURES}), chart)
        side = expected if limit.name == "surplus" else 1.0 - expected
        np.testing.assert_allclose(shared * value(rest, chart), side, atol=1e-11)


def test_the_charts_denominator_lacks_its_lowest_power_of_rho():
    made = conductor()
    assert made.corner
    assert made.group_orders == (1.0, 3.0)
    _, _, q = made.chart(COEFFICIENTS)
    plain = value(made.denominator_expression(COEFFICIENTS), POINTS)
    rho = POINTS["alpha"] + POINTS["mu"]
    np.testing.assert_allclose(value(q, chart_points(POINTS)) * rho**3, plain, rtol=1e-12)


def test_columns_factors_and_data_make_up_the_value():
    """What the fitting sees, put together by hand, is the value: with corners among the points."""
    made = conductor()
    alpha, mu = np.meshgrid([0.0, 1e-4, 0.3, 1.0], [1e-5, 1e-3, 0.3, 1.0])
    points = {"alpha": np.r_[0.0, alpha.ravel()], "mu": np.r_[0.0, mu.ravel()]}
    p, q = made.columns(points)
    ratio = p @ COEFFICIENTS[:6] / (q @ np.r_[1.0, COEFFICIENTS[6:]])
    (factor,) = made.factors(points)
    got = value(made.expression(COEFFICIENTS), points)
    np.testing.assert_allclose(1.0 - factor * ratio, got, atol=1e-11)
    assert made.data(points).shape == (0, 17)


def test_the_corner_is_seen_as_it_is_evaluated():
    """At alpha = mu = 0 the fit's row has the limit alpha = 0 first, as the expression does; E(0, 0) = 1."""
    zero = np.zeros(1)
    both = chart_points({"alpha": zero, "mu": zero})
    assert (both["t"], both["rho"]) == (0.0, 0.0)
    assert chart_points({"mu": np.array([0.0, 0.5])})["t"].tolist() == [0.0, 0.0]
    assert chart_points({"alpha": np.array([0.0, 0.5])})["t"].tolist() == [1.0, 1.0]


def test_a_form_of_the_cosine_alone_at_its_end():
    """Q = mu + mu^2, divided by mu: 1 at mu = 0."""
    made = Structure(head("ratio"), ("mu",), (np.array([[1.0], [3.0]]),), np.array([[1.0], [2.0]]))
    mu = np.array([0.0, 0.25, 1.0])
    p, q = made.columns({"mu": mu})
    np.testing.assert_allclose(q.sum(axis=1), 1.0 + mu)
    np.testing.assert_allclose(p.sum(axis=1), 1.0 + mu**2)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_values_are_finite_at_the_corners_and_exact_without_roughness(kind):
    ends = np.array([0.0, 1e-30, 1e-12, 1e-6, 1e-3, 1.0], dtype=kind)
    for alpha, mu in itertools.product(ends, ends):
        got = value(conductor().expression(COEFFICIENTS), {"alpha": alpha[None], "mu": mu[None]})
        assert got.dtype == kind
        assert np.isfinite(got[0])
        assert -1e-5 <= got[0] <= 1.0
        if alpha == 0.0:
            assert got[0] == 1.0


def test_json_reads_back_bit_for_bit():
    for made in (conductor(), *(of_head(name) for name in HEADS)):
        coefficients = np.random.default_rng(4).normal(size=made.count)
        again = Structure.from_dict(json.loads(json.dumps(made.to_dict())))
        assert again.to_dict() == made.to_dict()
        assert again.variables == made.variables
        # Expressions are one object for each distinct expression.
        assert again.expression(coefficients) is made.expression(coefficients)


def test_unused_features_are_dropped_with_the_function_unchanged():
    rows = np.array([[1.0, 0.0, 2.0], [0.0, 0.0, 0.0]])
    made = Structure(head("corner"), ("alpha", "r", "mu"), (rows,), rows)
    less = made.without_unused()
    assert less.features == ("alpha", "mu")
    c = [0.3, 0.4, 0.5]
    np.testing.assert_allclose(
        value(less.expression(c), POINTS), value(made.expression(c), POINTS), rtol=1e-15
    )


def test_a_feature_that_is_the_last_of_its_coordinate_stays():
    rows = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    made = Structure(head("ratio"), ("alpha", "mu", "root_mu"), (rows,), rows).without_unused()
    assert made.variables == ("mu", "alpha")
    assert len(made.features) == 2
    constant = Structure(
        head("ratio"), ("alpha", "r"), (np.zeros((1, 2)),), np.zeros((1, 2))
    ).without_unused()
    assert constant.variables == ("alpha",)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"features": ("alpha", "mou")}, "unknown feature 'mou'"),
        ({"features": ("alpha", "alpha")}, "features, each once"),
        ({"features": ()}, "features, each once"),
        ({"numerators": ()}, "head 'corner' needs 1 numerators, got 0"),
        ({"numerators": ([[1, 0]], [[0, 1]])}, "needs 1 numerators, got 2"),
        ({"numerators": ([[-1, 0]],)}, "numerator: exponents must be in 0..64"),
        ({"numerators": ([[np.nan, 0]],)}, "exponents must be in 0..64"),
        ({"numerators": ([[1, 0], [1, 0]],)}, "an exponent row repeats"),
        ({"numerators": ([[1, 0, 0], [0, 1, 0]],)}, "rows of 2 numbers, for alpha, mu"),
        ({"numerators": ([1, 0, 0, 1],)}, "rows of 2 numbers"),
        ({"numerators": ([[1, 0], [1]],)}, "rows of 2 numbers"),
        ({"numerators": ([["a", 0]],)}, "rows of 2 numbers"),
        ({"numerators": (np.empty((0, 2)),)}, "at least one term"),
        ({"denominator": [[65, 0]]}, "denominator: exponents must be in 0..64"),
        ({"denominator": []}, "denominator: exponents must be rows of 2"),
        ({"denominator": [[4, 0]]}, "outgrows its factor"),
    ],
)
def test_terms_that_do_not_fit_are_told(change: dict, words: str):
    good = {"features": ("alpha", "mu"), "numerators": ([[1, 0]],), "denominator": [[3, 0]]}
    Structure(head("corner"), **good)
    with pytest.raises(EcfitError, match=words) as caught:
        Structure(head("corner"), **{**good, **change})
    assert "\n" not in str(caught.value)


def test_a_charted_form_is_the_same_function():
    plain = conductor()
    made = replace(plain, charted=True)
    expected = value(plain.expression(COEFFICIENTS), POINTS)
    np.testing.assert_allclose(value(made.expression(COEFFICIENTS), POINTS), expected, rtol=1e-13)
    corner = {"alpha": np.array([0.0, 0.0, 1e-30]), "mu": np.array([0.0, 1e-6, 0.0])}
    np.testing.assert_allclose(value(made.expression(COEFFICIENTS), corner), 1.0, rtol=1e-12)
    rho = POINTS["alpha"] + POINTS["mu"]
    plain_q = value(plain.divisor(COEFFICIENTS), POINTS)
    np.testing.assert_allclose(value(made.divisor(COEFFICIENTS), POINTS) * rho**3, plain_q, rtol=1e-12)


@pytest.mark.parametrize("name", sorted(set(HEADS) - {"average", "times-x"}))
def test_every_head_may_be_charted(name: str):
    plain = of_head(name)
    coefficients = np.random.default_rng(3).uniform(0.0, 1.0, plain.count)
    points = {**POINTS, "ior": 1.0 + POINTS["F0"], "diffuse_roughness": POINTS["F0"], "sigma": POINTS["F0"]}
    made = replace(plain, charted=True)
    expected = value(plain.expression(coefficients), points)
    np.testing.assert_allclose(value(made.expression(coefficients), points), expected, rtol=1e-11, atol=1e-12)


def test_a_charted_form_does_not_underflow_in_half_precision():
    plain = conductor()
    rng = np.random.default_rng(4)
    narrow = {n: (10.0 ** rng.uniform(-3.5, 0.0, 500)).astype(np.float16) for n in ("alpha", "mu")}
    wide = {n: x.astype(np.float64) for n, x in narrow.items()}
    expected = value(plain.expression(COEFFICIENTS), wide)
    errors = [
        np.abs(np.asarray(value(replace(plain, charted=c).expression(COEFFICIENTS), narrow)) - expected)
        for c in (False, True)
    ]
    assert not np.all(np.isfinite(errors[0]))
    assert np.nanmax(errors[0]) > 0.02
    assert errors[1].max() < 2e-3


def test_charted_survives_json_and_plain_forms_do_not_mention_it():
    made = replace(conductor(), charted=True)
    again = Structure.from_dict(json.loads(json.dumps(made.to_dict())))
    assert again.charted
    assert again.to_dict() == made.to_dict()
    assert "charted" not in conductor().to_dict()
    assert not Structure.from_dict(conductor().to_dict()).charted


def test_charted_needs_the_corners_coordinates():
    with pytest.raises(EcfitError, match="charted is for forms of alpha and mu"):
        Structure(head("ratio"), ("r",), (np.ones((1, 1)),), np.ones((1, 1)), charted=True)
    with pytest.raises(EcfitError, match="charted must be true or false"):
        replace(conductor(), charted="yes")
