"""Heads: the chart sees the same function, what is taken out of the deficit is put back, limits are exact."""

import pickle
import re
from dataclasses import asdict

import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.expressions import const, value, var
from ecfit.forms.features import FEATURES, monomial, scaled
from ecfit.forms.heads import FRESNELS, HEADS, Head, head
from ecfit.forms.structured import Structure, head_from

RNG = np.random.default_rng(2)
N = 300
POINTS = {
    "mu": RNG.uniform(1e-3, 1.0, N),
    "alpha": RNG.uniform(1e-3, 1.0, N),
    "F0": RNG.uniform(1e-3, 1.0, N),
    "ior": RNG.uniform(1.0, 3.0, N),
    "diffuse_roughness": RNG.uniform(0.0, 1.0, N),
    "sigma": RNG.uniform(0.0, 1.5, N),
}
RHO = POINTS["alpha"] + POINTS["mu"]
CHART = {**POINTS, "rho": RHO, "t": POINTS["alpha"] / RHO}


def charted(found: Head, order: float = 0.0):
    """(value, what is held) in the chart with ratios rho^order (0.1 + 0.2 i + 0.3 t)."""
    ratios = [const(0.1 + 0.2 * i) + 0.3 * var("t") for i in range(found.ratios)]
    return found.in_chart(ratios, [order] * found.ratios)


@pytest.mark.parametrize("name", HEADS)
def test_the_chart_sees_the_same_value(name: str):
    found = head(name)
    alpha, mu = var("alpha"), var("mu")
    t = alpha / (alpha + mu)
    plain = found.expression([const(0.1 + 0.2 * i) + 0.3 * t for i in range(found.ratios)])
    np.testing.assert_allclose(
        value(charted(found)[0], CHART) + 0.0 * RHO, value(plain, POINTS) + 0.0 * RHO, rtol=1e-11, atol=1e-13
    )


@pytest.mark.parametrize(("name", "which"), [(n, i) for n, h in HEADS.items() for i in range(len(h.held))])
def test_deficit_and_surplus_are_what_is_left_to_the_ends(name: str, which: int):
    found = head(name)
    got, rests = charted(found)
    limit, rest = found.held[which], rests[which]
    shared = monomial(limit.shared, {n: scaled(n) for n in FEATURES})
    expected = value(got, CHART) if limit.name == "surplus" else 1.0 - value(got, CHART)
    # Of alpha and mu, t and m stand outside; the powers of rho are within.
    product = value(shared, CHART) * value(rest, CHART) + 0.0 * RHO
    np.testing.assert_allclose(product, expected + 0.0 * RHO, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "at", "expected"),
    [
        ("corner", {"alpha": 0.0}, 1.0),
        ("corner-product", {"alpha": 0.0}, 1.0),
        ("corner-product", {"mu": 0.0}, 1.0),
        ("masking", {"alpha": 0.0}, 1.0),
        ("masking-root", {"alpha": 0.0}, 1.0),
        ("schlick-b", {"alpha": 0.0}, 0.7**5),
        ("two-point", {"F0": 0.0}, 0.0),
        ("two-point", {"F0": 1.0}, 1.0),
        ("average", {"alpha": 0.0}, 1.0),
        ("fujii", {"mu": 0.0}, 1.0),
        ("fujii", {"diffuse_roughness": 0.0}, 1.0),
        ("fujii", {"mu": 1.0}, 1.0 / (1.0 + 0.3 * (0.5 - 2.0 / (3.0 * np.pi)))),
        ("qualitative", {"sigma": 0.0}, 1.0),
        ("times-x", {"ior": 1.0}, 0.0),
    ],
)
def test_limits_are_exact_whatever_the_ratio(name: str, at: dict[str, float], expected: float):
    found = head(name)
    for ratio in (0.0, 0.7, 3.0):
        whole = found.expression([const(ratio)] * found.ratios)
        points = {
            "mu": 0.3,
            "alpha": 0.5,
            "F0": 0.4,
            "ior": 1.5,
            "diffuse_roughness": 0.3,
            "sigma": 0.5,
            **at,
        }
        got = value(whole, {k: np.array(v) for k, v in points.items()})
        assert float(got) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("name", ["masking", "masking-root"])
def test_masking_alone_is_left_without_reflectance(name: str):
    whole = head(name).expression([const(0.8)])
    points = {"mu": np.array(0.6), "alpha": np.array(0.25), "F0": np.array(0.0)}
    g1 = 2.0 / (1.0 + np.sqrt(1.0 + 0.0625 * (1.0 / 0.36 - 1.0)))
    assert float(value(whole, points)) == pytest.approx(g1, abs=1e-15)


def test_two_points_without_roughness_are_fresnel():
    """alpha = 0 leaves F(mu) at both points; Fresnel's equations in their textbook form."""
    mu, ior = POINTS["mu"], 1.0 + POINTS["F0"]
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2
    whole = head("two-point").expression([const(0.3), const(0.9), const(0.4)])
    got = value(whole, {"mu": mu, "alpha": np.zeros(N), "F0": f0})
    cos_t = np.sqrt(1.0 - (1.0 - mu**2) / ior**2)
    s, p = (mu - ior * cos_t) / (mu + ior * cos_t), (cos_t - ior * mu) / (cos_t + ior * mu)
    np.testing.assert_allclose(got, 0.5 * (s**2 + p**2), atol=1e-12)


@pytest.mark.parametrize("name", FRESNELS)
def test_fresnel_factors_have_their_ends(name: str):
    for kind in (np.float64, np.float32):
        f0 = np.linspace(0.0, 1.0, 7, dtype=kind)
        normal, grazing = (value(FRESNELS[name](const(c)), {"F0": f0}) for c in (1.0, 0.0))
        np.testing.assert_allclose(normal, f0, atol=4.0 * np.finfo(kind).eps)
        np.testing.assert_allclose(grazing[1:], 1.0, atol=4.0 * np.finfo(kind).eps)
        # Without an interface nothing is reflected; Schlick's formula does not know.
        assert grazing[0] == (0.0 if name == "exact" else 1.0)


def test_a_ratio_that_outgrows_its_factor_is_refused():
    assert head("corner").orders([-2.0]) == (0.0,)
    with pytest.raises(EcfitError, match="head 'corner': P / Q outgrows its factor at alpha = mu = 0"):
        head("corner").orders([-2.5])


OWN = {
    "name": "own",
    "factors": [{"alpha": 1}],
    "lets": [["y", "1 - X"]],
    "text": "y*y",
    "deficit": "X + X*y",
    "limits": "E = 1 at alpha = 0",
}


def test_a_head_of_ones_own():
    found = head_from(OWN)
    points = {"mu": np.array(0.6), "alpha": np.array(0.25)}
    assert value(found.expression([const(0.8)]), points) == pytest.approx((1.0 - 0.2) ** 2)
    assert found.features == ("alpha",)
    whole, (deficit,) = charted(found)
    np.testing.assert_allclose(value(deficit, CHART), 1.0 - value(whole, CHART), atol=1e-13)
    assert asdict(head_from(asdict(found))) == asdict(found)
    assert head_from(found) is found
    assert head_from("corner") is HEADS["corner"]


def test_heads_are_written_out_whole_in_every_process():
    """One with the name of ours is not ours; and ours that came to a worker, as a copy, is written alike."""
    mine = head_from({"name": "corner", "factors": [{}], "text": "X"})
    assert asdict(head_from(asdict(mine))) == asdict(mine) != asdict(HEADS["corner"])
    here = Structure.from_dict(
        {"head": "corner", "features": ["mu"], "numerators": [[[1.0]]], "denominator": [[0.0]]}
    )
    assert here.to_dict() == pickle.loads(pickle.dumps(here)).to_dict()
    assert here.to_dict()["head"]["text"] == HEADS["corner"].text


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"text": "Y"}, "head 'own': formula: unknown name 'Y'"),
        ({"text": "X +"}, "head 'own': formula: cannot read 'X +'"),
        ({"text": 3}, "head 'own': formula: expected text"),
        ({"deficit": "X1"}, "head 'own': formula: unknown name 'X1'; did you mean 'X'"),
        ({"factors": []}, "head 'own': needs at least one factor"),
        ({"factors": {"alpha": 2}}, "factors of a head must be a list"),
        ({"factors": ["alpha"]}, "factors of a head must be a list"),
        ({"factors": [{"alfa": 2}]}, "unknown feature 'alfa'"),
        ({"factors": [{"alpha": -2}]}, "head 'own': the exponent of alpha must be in 0..64"),
        ({"shared": {"alpha": "x"}}, "head 'own': the exponent of alpha"),
        ({"lets": [["y"]]}, "head 'own': malformed"),
        ({"lets": 3}, "head 'own': malformed"),
        ({"lets": [["X", "1"]]}, "'X' cannot be defined"),
        ({"fresnel": "cook"}, "unknown Fresnel factor 'cook': expected one of exact, schlick"),
        ({"deficits": "X"}, "unknown field of a head 'deficits'.*did you mean 'deficit'"),
        ({"text": None}, "head 'own': formula: expected text"),
    ],
)
def test_a_wrong_head_is_told(change: dict, words: str):
    with pytest.raises(EcfitError, match=re.escape(words).replace(r"\.\*", ".*")) as caught:
        head_from({**OWN, **change})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("cornr", "unknown head 'cornr'.*did you mean 'corner'"),
        (None, "a head is a name or a table of its fields, got None"),
        (3, "a head is a name"),
        ({"name": "x", "factors": [{}]}, "a head needs text"),
        ({}, "a head needs name"),
    ],
)
def test_what_is_no_head_is_told(given, words: str):
    with pytest.raises(EcfitError, match=words):
        head_from(given)
