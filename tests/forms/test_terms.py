"""Exponents: their order, their validation, and evaluation in NumPy and JAX alike."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from ecfit.errors import EcfitError
from ecfit.forms import Polynomial, Rational, Terms, form, total_degree
from ecfit.forms.terms import change_basis


def test_the_order_is_that_of_the_published_coefficients():
    # Sforza & Pellacini 2022, eq. 24: 1, x, y, x2, xy, y2, x3, x2y, xy2, y3.
    assert total_degree(2, 3).tolist() == [
        [0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3],
    ]  # fmt: skip
    # eq. 25 begins 1, x, y, z, x2, xy, xz, y2, yz, z2.
    assert total_degree(3, 2).tolist() == [
        [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1],
        [2, 0, 0], [1, 1, 0], [1, 0, 1], [0, 2, 0], [0, 1, 1], [0, 0, 2],
    ]  # fmt: skip


@pytest.mark.parametrize(("variables", "count"), [(2, 19), (3, 39)])
def test_degree_three_has_the_published_number_of_coefficients(variables: int, count: int):
    assert Rational(degree=3).terms(variables).count == count


@pytest.mark.parametrize("variables", [1, 2, 3])
def test_numpy_and_jax_evaluate_the_quotient_of_monomials(variables: int):
    rng = np.random.default_rng(0)
    terms = Rational(numerator=3, denominator=2).terms(variables)
    coefficients = rng.normal(size=terms.count)
    points = [rng.uniform(-1.0, 1.0, (4, 3)) for _ in range(variables)]
    flat = np.stack([p.ravel() for p in points], axis=1)

    def plain(exponents: np.ndarray, c: np.ndarray) -> np.ndarray:
        return (np.prod(flat[:, None, :] ** exponents[None], axis=2) @ c).reshape(4, 3)

    a, b = terms.split(coefficients)
    expected = plain(terms.numerator, np.asarray(a)), 1.0 + plain(terms.denominator, np.asarray(b))
    for got in (terms.parts(coefficients, points), jax.jit(terms.parts)(coefficients, points)):
        np.testing.assert_allclose(got[0], expected[0], rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(got[1], expected[1], rtol=1e-12, atol=1e-13)
    assert isinstance(terms.parts(coefficients, points)[0], np.ndarray)
    assert isinstance(terms.parts(jnp.asarray(coefficients), points)[0], jax.Array)


@pytest.mark.parametrize(
    ("numerator", "denominator", "words"),
    [
        ([[0.5]], [[1]], "integers"),
        ([[-1]], [[1]], "integers"),
        ([[101]], [[1]], "integers"),
        ([[0], [0]], [[1]], "repeats"),
        ([[0]], [[0]], "constant is 1 by convention"),
        ([[0]], [[1, 0]], "number of variables"),
        ([0, 1], [[1]], "matrix"),
        ([["a"]], [[1]], "integers"),
    ],
)
def test_terms_without_meaning_are_refused(numerator, denominator, words: str):
    with pytest.raises(EcfitError, match=words):
        Terms(numerator, denominator)


@pytest.mark.parametrize("degree", [0, 200, 2.5, True, "3", None])
def test_a_degree_outside_its_range_is_refused(degree):
    with pytest.raises(EcfitError):
        Polynomial(degree)
    with pytest.raises(EcfitError):
        Rational(degree)


def test_forms_by_name_and_their_mistakes():
    assert form("rational", numerator=4, denominator=2).degree == "4/2"
    with pytest.raises(EcfitError, match="did you mean 'rational'"):
        form("ratoinal", degree=2)
    with pytest.raises(EcfitError, match="does not take"):
        form("polynomial", numerator=2)
    with pytest.raises(EcfitError, match="either degree"):
        form("rational", degree=2, numerator=2)


def test_a_coarser_form_has_a_subset_of_the_terms():
    large: Rational | None = Rational(numerator=4, denominator=2)
    while large is not None:
        small = large.coarser()
        if small is not None:
            for many, few in zip(
                (large.terms(2).numerator, large.terms(2).denominator),
                (small.terms(2).numerator, small.terms(2).denominator),
                strict=True,
            ):
                assert {tuple(r) for r in few.tolist()} <= {tuple(r) for r in many.tolist()}
        large = small  # type: ignore[assignment]


@pytest.mark.parametrize("variables", [1, 2, 3])
def test_a_grid_is_evaluated_as_its_points_are(variables: int):
    """Nodes of unlike number, so that no two dimensions can be mistaken for each other."""
    rng = np.random.default_rng(1)
    nodes = [rng.uniform(-1.0, 1.0, 4 + v) for v in range(variables)]
    mesh = np.meshgrid(*nodes, indexing="ij")
    for made in (Rational(numerator=3, denominator=2), Polynomial(3)):
        terms = made.terms(variables)
        coefficients = rng.normal(size=terms.count)
        for got, expected in zip(
            terms.on_grid(coefficients, nodes), terms.parts(coefficients, mesh), strict=True
        ):
            assert got.shape == tuple(len(n) for n in nodes)
            np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-12)


def test_a_change_of_basis_is_that_of_the_functions():
    """Products of (1 + 2 t)^j and t^k in place of monomials of two variables."""
    exponents = total_degree(2, 2)
    # Rows: 1, 1 + 2 x, (1 + 2 x)^2 as coefficients of 1, x, x^2; y stays.
    line = np.array([[1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 4.0, 4.0]])
    coefficients = np.arange(1.0, 7.0)
    plain = change_basis(coefficients, exponents, [line, np.eye(3)])
    x, y = 0.3, -0.7
    expected = coefficients @ ((1.0 + 2.0 * x) ** exponents[:, 0] * y ** exponents[:, 1])
    assert plain @ (x ** exponents[:, 0] * y ** exponents[:, 1]) == pytest.approx(expected, rel=1e-14)


def test_conversion_divides_by_the_new_constant_of_the_denominator():
    """(1 + x) / (3 + x) at x = 1 + 2 t: (2 + 2 t) / (4 + 2 t)."""
    terms = Rational(1).terms(1)
    line = np.array([[1.0, 0.0], [1.0, 2.0]])
    found = terms.converted(np.array([1.0, 1.0]), np.array([3.0, 1.0]), [line])
    np.testing.assert_allclose(found, [0.5, 0.5, 0.5], rtol=1e-15)
    # 1 + x at x = -1 + t has no constant.
    gone = terms.converted(np.array([1.0, 1.0]), np.array([1.0, 1.0]), [np.array([[1.0, 0.0], [-1.0, 1.0]])])
    assert not np.all(np.isfinite(gone))


def test_an_unguarded_rational_is_another_form_of_the_same_terms():
    """Results of the two must not be mistaken for each other, nor start from each other."""
    free, guarded = Rational(3, guarded=False), Rational(3)
    assert (free.name, guarded.name) == ("rational-unguarded", "rational")
    assert free.may_have_poles
    assert not guarded.may_have_poles
    np.testing.assert_array_equal(free.terms(2).numerator, guarded.terms(2).numerator)
    coarser = free.coarser()
    assert coarser is not None
    assert coarser.may_have_poles
    assert form("rational", degree=3, guarded=False).name == free.name
    assert not Polynomial(3).may_have_poles


@pytest.mark.parametrize("guarded", [1, "no", None])
def test_guarded_is_true_or_false(guarded):
    with pytest.raises(EcfitError, match="guarded"):
        Rational(2, guarded=guarded)
