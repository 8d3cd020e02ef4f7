"""Source text of every language: names, comments, coordinates, factors, derivatives, mistakes."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest

from ecfit.approximation import Lookup, find, shipped
from ecfit.approximation.shipped import shipped_folder
from ecfit.errors import EcfitError
from ecfit.export import LANGUAGES, code, source
from ecfit.export.contract import fingerprint
from ecfit.export.coordinates import arguments
from ecfit.export.evidence import evidence_of
from ecfit.files import read_json
from ecfit.fitting import Fit
from ecfit.metrics import Errors

EVERY = sorted(LANGUAGES)


def run(text: str) -> dict:
    """The names that exported Python defines."""
    out: dict = {}
    exec(text, out)
    return out


def body(text: str) -> str:
    return "\n".join(x for x in text.splitlines() if not x.startswith(("//", "#")))


@pytest.mark.parametrize("language", EVERY)
def test_a_file_says_what_it_is(language):
    fit = shipped("conductor-10")
    text = fit.to_code(language, name="E1")
    comment = [x for x in text.splitlines() if x.startswith(("//", "#"))]
    whole = "\n".join(comment)
    for word in ("separable", "ggx", "unit", "energy", "directional-albedo", "alpha in [0, 1]", "proved",
                 "E1(mu, alpha)", "0.0018", "10 numbers", fingerprint(fit), "Identifier: MIT-0"):  # fmt: skip
        assert word in whole
    assert max(map(len, text.splitlines())) <= 104
    assert text.endswith("\n")
    assert not text.endswith("\n\n")


@pytest.mark.parametrize("language", EVERY)
def test_every_language_writes_one_function_without_arrays_loops_or_powers(language):
    fit = shipped("dielectric-entering-20")
    text = body(code(fit, language, name="E"))
    assert len(re.findall(r"\bE\(", text)) == 1
    assert not re.search(r"\b(pow|powf|for|while)\b|\[|\{\d", text)
    assert all(f"{abs(c):.6g}" in text for c in fit.coefficients if 0.1 < abs(c) < 10.0)


def test_the_languages_hold_the_same_numbers():
    found = {
        language: re.findall(r"\d+\.\d+(?:e-?\d+)?|\de-\d+", body(code(shipped("glossy-20"), language)))
        for language in EVERY
    }
    assert len({tuple(n) for k, n in found.items() if k not in ("c", "cpp", "python")}) == 1
    assert {*found["c"]} == {*found["glsl"]} == {*found["cpp"]}


def test_published_fits_name_their_source():
    text = code(find("sforza-pellacini-2022-conductor"), "glsl")
    assert "Sforza & Pellacini 2022" in text
    assert "The coefficients are their authors'" in text
    assert "not measured here" in text


def test_a_fit_of_a_study_tells_its_errors(tmp_path):
    """`Fit.to_code` and the file that a study writes say the same."""
    errors = Errors(1e-4, 2e-4, 0.0123, {"mu": 0.0, "r": 1.0}, 1e-4, 2e-4)
    fit = find("sforza-pellacini-2022-conductor")
    done = Fit(fit, errors, fit.smallest_denominator(), (0.0, 1.0), "converged", 7, 1)
    assert "largest 0.012, mean 0.0001" in done.to_code("c")
    done.save(tmp_path / "fit.json")
    approximation, evidence = source(str(tmp_path / "fit.json"))
    assert code(approximation, "c", evidence=evidence) == done.to_code("c")


def test_the_points_of_an_evidence_are_those_of_the_certificate():
    data = read_json(shipped_folder() / "conductor-10.json")
    assert "(measured at 40000 points)" in " ".join(evidence_of(data))
    data["certificate"]["single_hard"]["points"] = 123
    assert "(measured at 20123 points)" in " ".join(evidence_of(data))


@pytest.mark.parametrize("name", shipped())
def test_python_is_the_approximation(name):
    fit = find(name)
    rng = np.random.default_rng(1)
    at = {v: rng.uniform(*d, 200) for v, d in zip(fit.variables, fit.domain, strict=True)}
    found = run(code(fit, "python", name="f"))["f"](**at)
    truth = fit.formula.value([at[v] for v in fit.variables])
    np.testing.assert_allclose(found, truth, rtol=1e-10, atol=1e-13)


def test_python_takes_another_array_module():
    from ecfit._jax import jax, jnp

    f = run(code(shipped("conductor-10"), "python", name="f"))["f"]
    slope = jax.grad(lambda mu: f(mu, 0.25, xp=jnp))(0.5)
    single = f(np.float32(0.5), np.full(3, 0.25, np.float32))
    assert single.dtype == np.float32
    assert np.isfinite(slope)


def test_factors():
    fit = shipped("conductor-10")
    found = run(code(fit, "python", name="E", factor=True))
    E = found["E"](0.3, 0.9)
    assert found["E_factor"](0.3, 0.9) == pytest.approx(1.0 / E)
    gold = np.array([1.0, 0.77, 0.34])
    np.testing.assert_allclose(found["E_metal"](0.3, 0.9, gold), 1.0 + gold * (1.0 / E - 1.0))
    limited = run(code(fit, "python", name="E", factor=True, least=0.9))
    assert limited["E_factor"](0.3, 0.9) == pytest.approx(1.0 / 0.9)


@pytest.mark.parametrize("name", ["average-4", "schlick-a-32", "dielectric-entering-reflection-25"])
def test_no_factor_of_what_is_no_albedo_of_a_whole_lobe(name):
    with pytest.raises(EcfitError, match="no albedo that a lobe is divided by"):
        code(shipped(name), "c", factor=True)


@pytest.mark.parametrize(("name", "views", "by"), [("conductor-10", (), "mu"), ("conductor-10", ("r",), "r"),
                                                   ("dielectric-leaving-20", ("ior",), "ior")])  # fmt: skip
def test_a_derivative_is_that_of_the_value(name, views, by):
    fit = shipped(name)
    found = run(code(fit, "python", name="E", coordinates=views, derivative=by))
    rng = np.random.default_rng(2)
    others = {"mu": (0.05, 0.95), "alpha": (0.05, 0.9), "r": (0.1, 0.9), "ior": (1.3, 2.9)}
    taken = ("mu", *(("r",) if "r" in views else ("alpha",)), *(("ior",) if "ior" in views else ()))
    at = {n: rng.uniform(*others[n], 100) for n in taken}
    step = 1e-6
    up, down = ({**at, by: at[by] + s} for s in (step, -step))
    numeric = (found["E"](**up) - found["E"](**down)) / (2 * step)
    np.testing.assert_allclose(found[f"E_d{by}"](**at), numeric, atol=2e-8, rtol=1e-6)


@pytest.mark.parametrize("name", shipped())
def test_a_derivative_is_finite_in_the_corners(name):
    """By every argument, at all corners and near them, in double and single precision."""
    fit = shipped(name)
    taken = arguments(fit, (), False)
    places = [(low, low + 1e-6 * (high - low), high) for low, high in taken.domain]
    at = np.array(list(itertools.product(*places))).T
    for by in taken.names:
        slope = run(code(fit, "python", name="E", derivative=by, evidence=()))[f"E_d{by}"]
        for kind in (np.float64, np.float32):
            assert np.all(np.isfinite(slope(*at.astype(kind)))), (by, kind)


@pytest.mark.parametrize("name", ["conductor-10", "conductor-half-10", "schlick-a-32"])
@pytest.mark.parametrize("clamp", [False, True])
def test_a_derivative_at_zero_is_the_limit(name, clamp):
    """Roots of alpha have no slope at 0, the function has one: to the right of it that is a difference."""
    found = run(code(shipped(name), "python", name="E", derivative="alpha", clamp=clamp, evidence=()))
    mu = np.array([0.3, 0.6, 1.0])
    numeric = (found["E"](mu, 2e-6) - found["E"](mu, 0.0)) / 2e-6
    np.testing.assert_allclose(found["E_dalpha"](mu, 0.0), numeric, rtol=0.01, atol=1e-5)
    assert not clamp or np.all(found["E_dalpha"](mu, -0.1) == 0.0)


def test_only_slopes_that_are_no_number_are_raised():
    fit = shipped("conductor-10")
    assert "alpha_safe" in code(fit, "c", derivative="alpha")
    assert "alpha_safe" not in code(fit, "c", derivative="mu")
    slope = run(code(fit, "python", name="E", derivative="mu"))["E_dmu"]
    assert np.all(slope(1e-7, np.array([0.0, 0.5])) == 0.0)


def test_a_coordinate_may_be_asked_for_twice():
    fit = shipped("conductor-10")
    assert code(fit, "c", coordinates=("r", "r")) == code(fit, "c", coordinates="r")


def test_coordinates_have_an_order():
    fit = find("sforza-pellacini-2022-dielectric-entering")  # of F0, r, mu
    for views, head in [((), "E(mu, r, F0)"), (("alpha", "ior"), "E(mu, alpha, ior)")]:
        assert head in code(fit, "python", name="E", coordinates=views)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"target": "rust"}, "unknown language 'rust': expected one of c, cpp, glsl"),
        ({"name": "2fast"}, "no name of a function"),
        ({"name": "a b"}, "no name of a function"),
        ({"name": "vec3"}, "reserved in GLSL"),
        ({"name": "_E"}, "underscores"),
        ({"name": "a__b"}, "underscores"),
        ({"name": "alpha"}, "'alpha' is the name of an argument: choose another name"),
        ({"name": "r", "coordinates": ("r",)}, "'r' is the name of an argument"),
        ({"name": "F0", "factor": True}, "'F0' is the name of an argument"),
        ({"name": "xp", "target": "python"}, "reserved in Python"),
        ({"name": "numpy", "target": "python"}, "reserved in Python"),
        ({"coordinates": ("roughness",)}, "no coordinate 'roughness': expected one of mu, alpha, r"),
        ({"coordinates": ("ior",)}, "no coordinate 'ior'"),
        (
            {"coordinates": ("r", "alpha")},
            "'r' and 'alpha' are two views of one coordinate: ask for one of them",
        ),
        ({"derivative": "r"}, "unknown argument for a derivative 'r'"),
        ({"factor": True, "least": 0.0}, r"in \(0, 1\]"),
    ],
)
def test_mistakes(change, message):
    target = change.pop("target", "glsl")
    with pytest.raises(EcfitError, match=message):
        code(shipped("conductor-10"), target, **change)


def test_locals_do_not_hide_functions_that_are_called():
    """`E_safe` is what the albedo E is called after it has been raised."""
    found = run(code(shipped("conductor-10"), "python", name="E_safe", factor=True))
    assert found["E_safe_metal"](0.3, 0.9, 1.0) == pytest.approx(1.0 / found["E_safe"](0.3, 0.9))


def test_locals_do_not_hide_what_a_language_has():
    """OSL has globals u, v, N; the features of our forms have such names too."""
    text = body(code(shipped("dielectric-leaving-50"), "osl"))
    assert not re.search(r"\bfloat [uvNP]\b", text)


def test_a_table_is_for_c_or_a_texture():
    fit = shipped("conductor-10")
    formula = Lookup(np.full((3, 4), 0.5), ((0.0, 1.0), (0.0, 1.0)), ("identity", "square"))
    table = replace(fit, formula=formula)
    with pytest.raises(EcfitError, match="in GLSL it is a texture"):
        code(table, "glsl")
    with pytest.raises(EcfitError, match="no derivative"):
        code(table, "c", derivative="mu")
